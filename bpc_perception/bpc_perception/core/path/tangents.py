"""Directions and spacing of a path."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.geometry import unit_vectors

TYPICAL_POINTS = 1000  # at most this number tells what is typical of a path


def smoothed_tangents(points: Array, index: Index, length: float) -> Array:
    """Return unit tangents (N, 3) of a path, each over a length [m] around its point.

    NaN where the path does not move at all.

    Args:
        points: (P, 3) the path [m].
        index: (N,) of the points whose tangents are wanted, increasing.
        length: of the path that makes up a tangent [m].
    """
    spacing = typical_spacing(points)
    reach = int(np.clip(round(length / 2 / spacing), 1, max((len(points) - 1) // 2, 1)))
    first, last = _pieces(points, index, max(length, 2 * spacing))
    # As far back as ahead, so that a bend does not turn the tangent.
    near = np.minimum(reach, np.minimum(index - first, last - index))
    step = points[index + near] - points[index - near]
    room = last - first
    for ends, way in ((index == last, -1), (index == first, 1)):
        step[ends] = _step_at_end(points, index[ends], way, room[ends], reach)
    return unit_vectors(_moving(step))


def _pieces(points: Array, index: Index, longest_step: float) -> tuple[Index, Index]:
    """Return the first and the last point (N,) of the piece in which each point lies.

    Which way the path went across a hole, where poses are missing or the nozzle was lifted, is
    not known: each piece between holes has directions of its own.
    """
    away = np.linalg.norm(np.diff(points, axis=0), axis=1)
    holes = np.flatnonzero(away > longest_step)
    piece = np.searchsorted(holes, index)
    return np.append(0, holes + 1)[piece], np.append(holes, len(points) - 1)[piece]


def _step_at_end(points: Array, end: Index, way: int, room: Index, reach: int) -> Array:
    """Return steps (E, 3) at ends of pieces, where a parabola takes the place of the missing side.

    Args:
        points: (P, 3) the path [m].
        end: (E,) the points at the ends.
        way: from the ends into their pieces, 1 or -1.
        room: (E,) steps from one end of each piece to the other.
        reach: how far to go into the pieces, if there is room [points].
    """
    by = np.clip(room // 2, 1, reach)
    one, two = (points[end + way * np.minimum(far, room)] for far in (by, 2 * by))
    return np.asarray(way * (4 * one - 3 * points[end] - two))


def _moving(step: Array) -> Array:
    """Return steps (N, 3), with the next that moves in place of any that does not.

    That is where the path turns back on itself, or stands.
    """
    moving = np.flatnonzero(np.linalg.norm(step, axis=1) > 0)
    if len(moving) == 0:
        return step
    after = np.minimum(np.searchsorted(moving, np.arange(len(step))), len(moving) - 1)
    return np.asarray(step[moving[after]])


def typical_spacing(points: Array) -> float:
    """Return the median distance between neighbours of a path (N, 3) [m]; 1e-6 or more."""
    start = np.arange(0, len(points) - 1, 1 + len(points) // TYPICAL_POINTS)
    return max(float(np.median(np.linalg.norm(points[start + 1] - points[start], axis=1))), 1e-6)


def tangents(path: Array) -> Array:
    """Return unit tangents (N, 3) of a path (N, 3): central differences, one-sided at its ends.

    NaN where the points on either side coincide, and for a path of less than two points.
    """
    if len(path) < 2:
        return np.full_like(path, np.nan)
    step = np.empty_like(path)
    step[1:-1] = path[2:] - path[:-2]
    step[0], step[-1] = path[1] - path[0], path[-1] - path[-2]
    length = np.linalg.norm(step, axis=1, keepdims=True)
    return np.divide(step, length, out=np.full_like(step, np.nan), where=length > 0)
