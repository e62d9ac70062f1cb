"""Whether ink that is pushed out after a pause goes on with the print before."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.path.deposition_path import DepositionPath

LONGEST_PAUSE_S = 3600.0  # for curing, or to change a tool
BESIDE_M = 0.015  # what begins farther beside the ink is another print
ABOVE_M, BELOW_M = 0.02, 0.002  # and what begins so much higher or lower
# What begins where the print began, and no layer higher, is the same program once more.
ANEW_M, ANEW_HEIGHT_M = 0.001, 0.00015


def goes_on(path: DepositionPath, stamp_ns: int, tip: Array) -> bool:
    """Return whether ink that begins at a tip (3,) [m], at a time [ns], goes on with a print.

    It does over, beside or above what was laid. z of the base frame points up.
    """
    laid = path.where(path.extruding)
    if not len(laid):
        return False
    pause = (stamp_ns - path.start_ns) * 1e-9 - laid.time[-1]
    from_begin = tip - laid.points[0]
    anew = np.hypot(*from_begin[:2]) <= ANEW_M and abs(from_begin[2]) <= ANEW_HEIGHT_M
    low, high = laid.points.min(axis=0), laid.points.max(axis=0)
    beside = np.hypot(*np.maximum(np.maximum(low - tip, tip - high), 0.0)[:2])
    return bool(pause <= LONGEST_PAUSE_S and not anew and beside <= BESIDE_M
                and low[2] - BELOW_M <= tip[2] <= high[2] + ABOVE_M)
