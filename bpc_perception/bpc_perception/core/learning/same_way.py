"""Whether a layer that is being printed goes the way that was learned from, and where on it.

The extruder may be switched on earlier or later than it was, so places are shifted; and a layer
lies above the one before, or a print beside the one before, so points are.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array
from bpc_perception.core.learning.layer_record import LONGEST_OOZE_M, SAME_PATH_M

BEGIN_M = 5e-3  # of the layer, by which its begin is found on the way learned from
IN_PLACE_M = 3e-3  # from it: higher by a layer; else it is printed elsewhere
LOST_M = 3e-3  # by which arc lengths of two layers may come apart, as of poses with noise
STEP_M = 5e-4
END_POINTS = 4  # that tell which way an end goes


def places_on(known_place: Array, known_points: Array, place: Array,
              points: Array) -> float | None:
    """Return what makes places of a layer places on the way learned from [m]; None = it left it.

    Args:
        known_place: (K,) arc lengths of the way learned from [m].
        known_points: (K, 3) of it [m].
        place: (N,) arc lengths from the first ink of the layer on, as far as it is printed [m].
        points: (N, 3) of the nozzle tip there [m].
    """
    ends = known_place[[0, -1]]
    known_place, known_points = _lengthened(known_place, known_points)

    def at(where: Array) -> Array:
        return np.column_stack([np.interp(where, known_place, axis) for axis in known_points.T])

    begin = place <= place[0] + BEGIN_M
    away, nearest = cKDTree(known_points).query(points[begin])
    further = 0.0
    if np.median(away) <= IN_PLACE_M:
        further = float(np.median(known_place[nearest] - place[begin]))
    place = place + further
    if abs(further) > LONGEST_OOZE_M or place[-1] > ends[1] + LONGEST_OOZE_M:
        return None
    shift = np.median(points[begin] - at(place[begin]), axis=0)
    inside = (place >= ends[0]) & (place <= ends[1])
    moved = points[inside] - shift
    slips = np.arange(-LOST_M, LOST_M + STEP_M / 2, STEP_M)
    off = np.min([np.linalg.norm(moved - at(place[inside] + slip), axis=1) for slip in slips],
                 axis=0)
    return further if not (off > SAME_PATH_M).any() else None


def _lengthened(place: Array, points: Array) -> tuple[Array, Array]:
    """Return a way (K,), (K, 3) that goes straight on at both ends, where ink may begin or end."""
    more = np.arange(STEP_M, LONGEST_OOZE_M + STEP_M, STEP_M)
    reach = min(END_POINTS, len(place) - 1)
    first, last = points[0] - points[reach], points[-1] - points[-1 - reach]
    first, last = (one / max(float(np.linalg.norm(one)), 1e-12) for one in (first, last))
    return (np.concatenate((place[0] - more[::-1], place, place[-1] + more)),
            np.concatenate((points[0] + more[::-1, None] * first, points,
                            points[-1] + more[:, None] * last)))
