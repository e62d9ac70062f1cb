"""Medians of interleaved runs: what else a machine does meets all alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping
import time

import numpy as np

ROUNDS = 15
Told = Callable[[int, int], None]  # of how much of how much is done
SLOW = 1.0  # [s]


def silent(_done: int, _total: int) -> None:
    """Nobody wants to be told."""


def interleaved(runs: Mapping[str, Callable[[], object]],
                rounds: int = ROUNDS, slow: float = SLOW) -> dict[str, tuple[float, float]]:
    """Median and 95th percentile of the time of each run [s], after one that does not count.

    Those that take longer than ``slow`` [s] are run once.
    """
    taken: dict[str, list[float]] = {name: [] for name in runs}
    first = {name: seconds(run) for name, run in runs.items()}
    for _ in range(rounds):
        for name, run in runs.items():
            if first[name] <= slow:
                taken[name].append(seconds(run))
    return {name: (float(np.median(times)), float(np.percentile(times, 95)))
            for name, times in ((name, taken[name] or [first[name]]) for name in runs)}


def clock(progress: Told, expected: float) -> Callable[[], None]:
    """What tells, whenever it is called, how much of the time expected has passed [s]."""
    start = time.monotonic()
    return lambda: progress(min(int(time.monotonic() - start), int(expected)), int(expected))


def seconds(run: Callable[[], object]) -> float:
    """How long a run takes [s]."""
    started = time.perf_counter()
    run()
    return time.perf_counter() - started
