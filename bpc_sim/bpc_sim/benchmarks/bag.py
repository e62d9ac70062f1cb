"""How many captures of a recording are measured a second, offline."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from bpc_perception.messages import topics
from bpc_perception.recording.contents import find_topics
from bpc_perception.recording.inputs import Inputs
from bpc_perception.recording.offline import measure_bag
from bpc_sim.benchmarks.timing import interleaved, silent, Told

Row = dict[str, object]


def run(given: Inputs, quick: bool = False, progress: Told = silent) -> list[Row]:
    """Rows of reading a recording, and of measuring it too; the same twice, or ValueError."""
    first, second = thicknesses(given), thicknesses(given)
    if not first:
        raise ValueError(f'bench bag: expected captures to measure in {given.bag.path}, '
                         'found none')
    for one, other in zip(first, second, strict=True):
        if not np.array_equal(one, other, equal_nan=True):
            raise ValueError('bench bag: expected the same twice, found profiles that differ')
    rounds, done = 1 if quick else 5, 0

    def timed(read_so: Callable[[Inputs], object]) -> None:
        nonlocal done
        read_so(given)
        done += 1
        progress(done, 2 * (1 + rounds))

    runs: dict[str, Callable[[], object]] = {
        'read': partial(timed, read), 'read and measure': partial(timed, thicknesses)}
    return [{'what': name, 'captures': len(first), 'median_s': median, 'p95_s': p95,
             'captures_per_s': len(first) / median}
            for name, (median, p95) in interleaved(runs, rounds, np.inf).items()]


def thicknesses(given: Inputs) -> list[np.ndarray]:
    """Thickness (N,) of every profile of a recording."""
    return [result.profile.thickness for result in measure_bag(
        given.bag, given.hand_eye, given.thickness, given.recorder) if result.profile is not None]


def read(given: Inputs) -> int:
    """Decode the messages that measuring needs; their number."""
    names = find_topics(given.bag, topics.CAMERA) | find_topics(given.bag, topics.PRINT)
    return sum(1 for _ in given.bag.messages(set(names)))
