"""Where the nozzle travels, as far as its motion tells: it is lifted, or fast."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.ndimage import median_filter

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.path.deposition_path import DepositionPath

# A lift rises or falls by this slope more than the bed around, and by this length in all.
LIFT_SLOPE = 0.1
LIFT_M = 0.00012
LOWERED = 0.4  # share of a lift that the nozzle is lowered by at least after travel
LAST_LIFT_M = 0.001  # a lift that ends a path is travel from here on; a layer is lower
TREND_M = 0.02  # of path that tells how the bed rises
FAST = 3.0  # as often as the usual speed, travel


def lifted_or_fast(path: DepositionPath, height: Array) -> Flags:
    """Return where (N,) the motion alone says that the nozzle travels."""
    if len(path) < 3:
        return np.zeros(len(path), bool)
    lifted = lifted_between(path.arc_length, height)
    duration = np.gradient(path.time)
    speed = np.gradient(path.arc_length) / duration
    slow = np.argsort(speed)
    passed = np.cumsum((duration * ~lifted)[slow])
    usual = speed[slow[min(int(np.searchsorted(passed, passed[-1] / 2)), len(slow) - 1)]]
    return lifted | (speed > FAST * usual)


def lifted_between(arc: Array, height: Array) -> Flags:
    """Return where (N,) the nozzle is between a lift and the next lowering, or on such a way.

    A rise that nothing lowers again is the next layer, unless it ends the path and is high.

    Args:
        arc: (N,) length of path [m].
        height: (N,) of the tip above the bed [m].
    """
    run = np.maximum(np.diff(arc), 1e-9)
    step = np.diff(height)
    slope = step / run
    window = 2 * int(TREND_M / 2 / np.median(run)) + 1
    trend = median_filter(slope, size=min(window, len(slope)), mode='nearest')
    way = np.where(np.abs(slope - trend) > LIFT_SLOPE, np.sign(slope - trend), 0.0)
    borders = np.concatenate(([0], np.flatnonzero(np.diff(way)) + 1))
    rise = np.add.reduceat(step - trend * run, borders)
    ends = np.append(borders[1:], len(way))
    lifts = [(int(start), int(end), float(up)) for start, end, up in zip(
        borders, ends, rise, strict=True) if way[start] and abs(up) >= LIFT_M]
    lifted = np.zeros(len(arc), bool)
    for start, end, _ in lifts:
        lifted[start + 1:end] = True
    if lifts and lifts[0][2] < 0:  # it came down to begin
        lifted[:lifts[0][1]] = True
    for (start, _, up), (_, end, down) in pairwise(lifts):
        if up > 0 and -down >= LOWERED * up:
            lifted[start + 1:end] = True
    if lifts and lifts[-1][2] >= LAST_LIFT_M:
        lifted[lifts[-1][0] + 1:] = True
    return lifted
