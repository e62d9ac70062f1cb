"""Whether ink that is pushed out after a pause goes on with the print before."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.path.deposition_path import DepositionPath

LONGEST_PAUSE_S = 3600.0  # for curing, or to change a tool
BESIDE_M = 0.015  # what begins farther beside the ink is another print
ABOVE_M, BELOW_M = 0.02, 0.002  # and what begins so much higher or lower
# What begins on ink, and no layer higher, is another print on the same place; but where the nozzle
# stopped, so far along the path, it goes on.
ON_INK_M, SAME_LAYER_M, STOPPED_M = 0.0005, 0.00015, 0.005


def goes_on(path: DepositionPath, stamp_ns: int, tip: Array) -> bool:
    """Return whether ink that begins at a tip (3,) [m], at a time [ns], goes on with a print.

    It does beside or above what was laid. z of the base frame points up.
    """
    laid = path.where(path.extruding)
    if not len(laid):
        return False
    pause = (stamp_ns - path.start_ns) * 1e-9 - laid.time[-1]
    away = laid.points - tip
    on_ink = (np.hypot(away[:, 0], away[:, 1]) <= ON_INK_M) & (np.abs(away[:, 2]) <= SAME_LAYER_M)
    anew = on_ink[laid.arc_length < laid.arc_length[-1] - STOPPED_M].any()
    low, high = laid.points.min(axis=0), laid.points.max(axis=0)
    beside = np.hypot(*np.maximum(np.maximum(low - tip, tip - high), 0.0)[:2])
    return bool(pause <= LONGEST_PAUSE_S and not anew and beside <= BESIDE_M
                and low[2] - BELOW_M <= tip[2] <= high[2] + ABOVE_M)
