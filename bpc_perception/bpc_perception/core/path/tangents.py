"""Directions and spacing of a path."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.filters import runs
from bpc_perception.core.geometry import unit_vectors

TYPICAL_POINTS = 1000  # at most this number tells what is typical of a path


def smoothed_tangents(points: Array, piece: Index, index: Index, length: float) -> Array:
    """Return unit tangents (N, 3) of a path, each over a length [m] around its point.

    Which way the path went between pieces, where it was not seen or the nozzle was lifted, is not
    known: each has directions of its own.

    NaN where the path does not move at all.

    Args:
        points: (P, 3) the path [m].
        piece: (P,) number of the piece that each point belongs to, never falling.
        index: (N,) of the points whose tangents are wanted, increasing.
        length: of the path that makes up a tangent [m].
    """
    spacing = typical_spacing(points)
    reach = int(np.clip(round(length / 2 / spacing), 1, max((len(points) - 1) // 2, 1)))
    first, last = _pieces(points, piece, index, max(length, 2 * spacing))
    # As far back as ahead, so that a bend does not turn the tangent.
    near = np.minimum(reach, np.minimum(index - first, last - index))
    step = points[index + near] - points[index - near]
    room = last - first
    for ends, way in ((index == last, -1), (index == first, 1)):
        step[ends] = _step_at_end(points, index[ends], way, room[ends], reach)
    return unit_vectors(_moving(step))


def _pieces(points: Array, piece: Index, index: Index,
            longest_step: float) -> tuple[Index, Index]:
    """Return the first and the last point (N,) of the piece in which each point lies.

    A hole, where poses are missing, divides a piece.
    """
    away = np.linalg.norm(np.diff(points, axis=0), axis=1)
    holes = np.flatnonzero((away > longest_step) | (piece[1:] != piece[:-1]))
    own = np.searchsorted(holes, index)
    return np.append(0, holes + 1)[own], np.append(holes, len(points) - 1)[own]


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


def tangents(path: Array, piece: Index | None = None) -> Array:
    """Return unit tangents (N, 3) of a path (N, 3): central differences, one-sided at its ends.

    NaN where the points on either side coincide, and for a path of less than two points. With
    numbers of its pieces (N,), each is a path of its own.
    """
    if len(path) < 2:
        return np.full_like(path, np.nan)
    index = np.arange(len(path))
    first, end = (0, len(path)) if piece is None else runs(piece)
    step = (path[np.minimum(index + 1, np.subtract(end, 1))]
            - path[np.maximum(index - 1, first)])
    length = np.linalg.norm(step, axis=1, keepdims=True)
    return np.divide(step, length, out=np.full_like(step, np.nan), where=length > 0)
