"""Medians of interleaved runs: other load on the machine slows all of them alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
import time

import numpy as np

ROUNDS = 15
SLOW_RUN_S = 1.0  # a run that takes longer is run once
Progress = Callable[[int, int], None]  # called with how much is done, and of how much


@dataclass(frozen=True)
class Timing:
    """How long a run takes.

    Attributes:
        median, p95: median and 95th percentile [s].
    """

    median: float
    p95: float


def no_progress(_done: int, _total: int) -> None:
    """Ignore the progress."""


def time_interleaved(runs: Mapping[str, Callable[[], object]], rounds: int = ROUNDS,
                     slow: float = SLOW_RUN_S) -> dict[str, Timing]:
    """Take the time of each run in turn, after a first round that does not count.

    Args:
        runs: what is timed, by name.
        rounds: how often each is timed.
        slow: those that take longer [s] are run once, and that first time counts.
    """
    taken: dict[str, list[float]] = {name: [] for name in runs}
    first = {name: seconds_of(run) for name, run in runs.items()}
    for _ in range(rounds):
        for name, run in runs.items():
            if first[name] <= slow:
                taken[name].append(seconds_of(run))
    return {name: _timing(taken[name] or [first[name]]) for name in runs}


def _timing(times: list[float]) -> Timing:
    return Timing(float(np.median(times)), float(np.percentile(times, 95)))


def progress_clock(progress: Progress, expected: float) -> Callable[[], None]:
    """Return a function that reports how much of the expected time [s] has passed by now."""
    start = time.monotonic()
    return lambda: progress(min(int(time.monotonic() - start), int(expected)), int(expected))


def seconds_of(run: Callable[[], object]) -> float:
    """Return how long a run takes [s]."""
    started = time.perf_counter()
    run()
    return time.perf_counter() - started
