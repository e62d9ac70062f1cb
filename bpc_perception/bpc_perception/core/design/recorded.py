"""Ink as the nozzle laid it, stroke after stroke."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import thinned
from bpc_perception.core.path.tangents import smoothed_tangents

TANGENT_M = 2e-3  # of path that tells its direction
STEP_M = 0.5e-3  # between points whose distances add up to a length: shorter ones are noise
SHORTEST_M = 0.5e-3


@dataclass(frozen=True)
class RecordedInk:
    """N points of strokes, in order.

    Attributes:
        points: (N, 3) nozzle tip in the robot base frame [m].
        directions: (N, 3) unit vectors; NaN = not known.
        stroke: (N,) number of the stroke, from 0, without holes.
        along: (N,) length of ink behind each, over all strokes [m].
        complete: whether nothing comes behind it.
    """

    points: Array
    directions: Array
    stroke: Index
    along: Array
    complete: bool

    def __len__(self) -> int:
        return len(self.stroke)

    @classmethod
    def of(cls, points: Array, stroke: Index, complete: bool) -> RecordedInk | None:
        """Return the ink of a path (N, 3) with numbers of strokes (N,), 0 = travel; or None."""
        laid = np.flatnonzero((stroke > 0) & np.isfinite(points).all(axis=1))
        piece = np.cumsum(np.diff(stroke[laid], prepend=0) != 0) - 1
        if not len(laid):
            return None
        points = points[laid]
        kept = _lengths(points, piece)[piece] >= SHORTEST_M  # others tell nothing
        if not kept.any():
            return None
        points, piece = points[kept], np.unique(piece[kept], return_inverse=True)[1]
        directions = smoothed_tangents(points, piece, np.arange(len(points)), TANGENT_M)
        step = np.append(0.0, np.linalg.norm(np.diff(points, axis=0), axis=1))
        step[np.diff(piece, prepend=0) != 0] = 0.0
        # Noise makes a way of short steps too long.
        true, rough = _lengths(points, piece), np.bincount(piece, step)
        return cls(points, directions, piece,
                   np.cumsum(step * (true / np.maximum(rough, 1e-12))[piece]), complete)

    @property
    def length(self) -> float:
        """Of all strokes together [m]."""
        return float(self.along[-1])

    @cached_property
    def lengths(self) -> Array:
        """Length (S,) of each stroke [m]."""
        return np.asarray(self.along[self._last] - self.along[self.begins])

    @cached_property
    def begins(self) -> Flags:
        """Where (N,) a stroke begins."""
        return np.asarray(np.diff(self.stroke, prepend=-1) != 0)

    @cached_property
    def ends(self) -> Flags:
        """Where (N,) a stroke ends, but for the last one, which may go on."""
        return self._last & (self.stroke < self.stroke[-1])

    @cached_property
    def _last(self) -> Flags:
        return np.asarray(np.diff(self.stroke, append=-1) != 0)

    def thinned(self, most: int) -> RecordedInk:
        """Return about this number of the points, with the ends of all strokes."""
        kept = thinned(self.stroke, max(1, -(-len(self) // most)))
        return RecordedInk(self.points[kept], self.directions[kept], self.stroke[kept],
                           self.along[kept], self.complete)


def _lengths(points: Array, piece: Index) -> Array:
    """Return the length (S,) of pieces of a path (N, 3), whose points have these numbers (N,)."""
    kept = _spaced(points, piece)
    step = np.linalg.norm(np.diff(points[kept], axis=0), axis=1)
    step[np.diff(piece[kept]) != 0] = 0.0
    return np.asarray(np.bincount(piece[kept][1:], step, int(piece[-1]) + 1), np.float64)


def _spaced(points: Array, piece: Index) -> Index:
    """Return the index (K,) of points about a step apart, with the ends of pieces."""
    step = np.linalg.norm(np.diff(points, axis=0), axis=1)
    typical = float(np.median(step)) if len(step) else STEP_M
    return thinned(piece, max(1, round(2 * STEP_M / max(typical, 1e-5))))
