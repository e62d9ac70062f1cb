"""Where the nozzle is about to go, if it goes on as it went."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.geometry import Plane, unit_vectors

BEND_M = 0.003  # of the path's end, which tells how it bends


def arc_ahead(points: Array, bed: Plane, distances: Array) -> Array:
    """Return points (K, 3) ahead of the end of a path, on the arc in which it ends.

    NaN where the path's end has no direction.

    Args:
        points: (N, 3) the path, or its last stroke [m].
        bed: plane of the bed, along which it goes on.
        distances: (K,) of the points along the arc [m].
    """
    back = np.linalg.norm(points - points[-1], axis=1)
    middle, first = _within(back, BEND_M / 2), _within(back, BEND_M)
    now, then = unit_vectors(bed.project(np.stack((
        points[-1] - points[middle], points[middle] - points[first]))) - bed.project(
            np.zeros(3)))
    side = np.cross(bed.normal, now)
    between = np.linalg.norm(points[-1] - points[first]) / 2
    bend = np.arctan2(-then @ side, then @ now) / between if first < middle else 0.0
    turn = bend * distances
    # Where the direction turned by ``turn``, the chord has half of that, and is that much shorter.
    chord = distances * np.sinc(turn / (2 * np.pi))
    # The end has the direction of its last half, in the middle of it.
    angle = turn / 2 + bend * between / 2
    return np.asarray(points[-1] + chord[:, None] * (
        np.cos(angle)[:, None] * now + np.sin(angle)[:, None] * side))


def _within(back: Array, distance: float) -> int:
    """Return the first of the last points (N,) that are all nearer to the end than a distance."""
    beyond: Flags = back > distance
    return 0 if not beyond.any() else len(back) - int(np.argmax(beyond[::-1]))
