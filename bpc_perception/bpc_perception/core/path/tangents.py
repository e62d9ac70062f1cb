"""Directions and spacing of a path."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.geometry import unit_vectors

TYPICAL_POINTS = 1000  # at most so many tell what is typical of a path


def smoothed_tangents(points: Array, index: Index, length: float) -> Array:
    """Unit tangents (N, 3) over a ``length`` [m] of the path (P, 3) around points (N,) of it."""
    spacing = typical_spacing(points)
    reach = int(np.clip(round(length / 2 / spacing), 1, max((len(points) - 1) // 2, 1)))
    # Which way it went across a hole, where poses are missing or the nozzle was lifted, is not
    # known: each piece between holes has directions of its own.
    away = np.linalg.norm(np.diff(points, axis=0), axis=1)
    holes = np.flatnonzero(away > max(length, 2 * spacing))
    piece = np.searchsorted(holes, index)
    first, last = np.append(0, holes + 1)[piece], np.append(holes, len(points) - 1)[piece]
    # As far back as ahead, so that a bend does not turn the tangent.
    near = np.minimum(reach, np.minimum(index - first, last - index))
    step = points[index + near] - points[index - near]
    # At the ends a parabola takes the place of the missing side.
    for ends, way in ((index == last, -1), (index == first, 1)):
        here, room = index[ends], (last - first)[ends]
        by = np.clip(room // 2, 1, reach)
        one, two = (points[here + way * np.minimum(far, room)] for far in (by, 2 * by))
        step[ends] = way * (4 * one - 3 * points[here] - two)
    # Where the path turns back on itself, or stands, the direction next to that counts.
    moving = np.flatnonzero(np.linalg.norm(step, axis=1) > 0)
    if len(moving):
        after = np.minimum(np.searchsorted(moving, np.arange(len(index))), len(moving) - 1)
        step = step[moving[after]]
    return unit_vectors(step)


def typical_spacing(points: Array) -> float:
    """Distance between neighbours of a path (N, 3) [m]; never quite nothing."""
    start = np.arange(0, len(points) - 1, 1 + len(points) // TYPICAL_POINTS)
    return max(float(np.median(np.linalg.norm(points[start + 1] - points[start], axis=1))), 1e-6)


def tangents(path: Array) -> Array:
    """Unit tangents (N, 3) of a path (N, 3) by central differences, one-sided at its ends.

    NaN where neighbouring points coincide.
    """
    if len(path) < 2:
        return np.full_like(path, np.nan)
    step = np.empty_like(path)
    step[1:-1] = path[2:] - path[:-2]
    step[0], step[-1] = path[1] - path[0], path[-1] - path[-2]
    length = np.linalg.norm(step, axis=1, keepdims=True)
    return np.divide(step, length, out=np.full_like(step, np.nan), where=length > 0)
