"""How many captures of a recording are measured per second, offline."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from bpc_perception.messages import topics
from bpc_perception.recording.contents import find_topics
from bpc_perception.recording.inputs import Inputs
from bpc_perception.recording.offline import measure_bag
from bpc_sim.benchmarks.timing import no_progress, Progress, time_interleaved

Row = dict[str, object]


def run(given: Inputs, quick: bool = False, progress: Progress = no_progress) -> list[Row]:
    """Time the reading of a recording, and reading with measuring.

    Raises:
        ValueError: there is nothing to measure, or two runs give different results.
    """
    first, second = thicknesses(given), thicknesses(given)
    if not first:
        raise ValueError(f'bench bag: expected captures to measure in {given.bag.path}, '
                         'found none')
    for one, other in zip(first, second, strict=True):
        if not np.array_equal(one, other, equal_nan=True):
            raise ValueError('bench bag: expected the same twice, found profiles that differ')
    rounds, done = 1 if quick else 5, 0

    def run_once(action: Callable[[Inputs], object]) -> None:
        nonlocal done
        action(given)
        done += 1
        progress(done, 2 * (1 + rounds))

    runs: dict[str, Callable[[], object]] = {
        'read': partial(run_once, read_messages),
        'read and measure': partial(run_once, thicknesses)}
    return [{'what': name, 'captures': len(first), 'median_s': timing.median,
             'p95_s': timing.p95, 'captures_per_s': len(first) / timing.median}
            for name, timing in time_interleaved(runs, rounds, np.inf).items()]


def thicknesses(given: Inputs) -> list[np.ndarray]:
    """Measure a recording; return the thickness (N,) [m] of every profile."""
    return [result.profile.thickness for result in measure_bag(
        given.bag, given.hand_eye, given.thickness, given.recorder) if result.profile is not None]


def read_messages(given: Inputs) -> int:
    """Decode the messages that measuring needs, and return their number."""
    names = find_topics(given.bag, topics.CAMERA) | find_topics(given.bag, topics.PRINT)
    return sum(1 for _ in given.bag.messages(set(names)))
