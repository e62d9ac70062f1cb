"""A design in short straight pieces, and which of them is near."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.design.design import Design, DesignStroke

SPACING_M = 0.2e-3  # as that of a profile
MOST_PIECES = 200_000
# A piece that runs across counts as if it were so much farther away: where strokes cross, the
# one is meant that runs the same way.
ACROSS_M = 1e-3


@dataclass(frozen=True)
class Pieces:
    """M pieces of a design, none longer than the spacing, in the order in which they are laid.

    Attributes:
        middle: (M, 3) [m].
        tangent: (M, 3) unit vectors along the stroke.
        half: (M,) half of the length of each [m].
        width: (M,) wanted [m]; NaN = not told.
        layer: (M,) number of the layer.
        stroke: (M,) number of the design's stroke, from 0.
        arc_length: (M,) of the middle along its stroke [m].
        opens, closes: (M,) whether it is the first of its stroke, or the last.
    """

    middle: Array
    tangent: Array
    half: Array
    width: Array
    layer: Index
    stroke: Index
    arc_length: Array
    opens: Flags
    closes: Flags

    def __len__(self) -> int:
        return len(self.half)

    @classmethod
    def of(cls, design: Design, spacing: float = SPACING_M) -> Pieces:
        """Return the pieces of a design, at most so long [m]; longer if they were too many."""
        spacing = max(spacing, design.length / MOST_PIECES)
        parts = [_pieces_of(stroke, spacing) for stroke in design.strokes]
        middle, tangent, half, width, arc_length = (
            np.concatenate([part[column] for part in parts]) for column in range(5))
        count = np.array([len(part[2]) for part in parts])
        ends = np.cumsum(count)
        number = np.arange(len(half))
        return cls(middle, tangent, half, width,
                   np.repeat([stroke.layer for stroke in design.strokes], count),
                   np.repeat(np.arange(len(parts)), count), arc_length,
                   np.isin(number, ends - count), np.isin(number, ends - 1))

    def where(self, kept: Flags) -> Pieces:
        """Return the pieces that are kept (M,)."""
        return Pieces(self.middle[kept], self.tangent[kept], self.half[kept], self.width[kept],
                      self.layer[kept], self.stroke[kept], self.arc_length[kept],
                      self.opens[kept], self.closes[kept])

    @cached_property
    def ink(self) -> Array:
        """Ink that lies behind the middle of each (M,), along all strokes [m]."""
        return np.asarray(np.cumsum(2 * self.half) - self.half)

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(np.hstack((self.middle, ACROSS_M * self.tangent)))

    def nearest(self, points: Array, directions: Array) -> Index:
        """Return the piece (N,) that is near each point and runs the same way; -1 = not known.

        Args:
            points: (N, 3) [m].
            directions: (N, 3) in which the path runs there, unit vectors.
        """
        known = np.isfinite(points).all(axis=1) & np.isfinite(directions).all(axis=1)
        found = np.full(len(points), -1)
        if known.any() and len(self):
            asked = np.hstack((points[known], ACROSS_M * directions[known]))
            found[known] = self._tree.query(asked)[1]
        return found

    def closest(self, points: Array) -> Index:
        """Return the piece (N,) that is nearest to each point (N, 3), whichever way it runs."""
        return np.asarray(cKDTree(self.middle).query(points)[1], np.intp)

    def offsets(self, points: Array, piece: Index) -> tuple[Array, Array]:
        """Return how far (N, 3) points (N, 3) are from pieces (N,), and along them (N,) [m].

        The offset is that from the nearest place of the piece. Along is counted from its middle.
        """
        away = points - self.middle[piece]
        along = np.einsum('nk,nk->n', away, self.tangent[piece])
        inside = np.clip(along, -self.half[piece], self.half[piece])
        return away - inside[:, None] * self.tangent[piece], along


def _pieces_of(stroke: DesignStroke, spacing: float) -> tuple[Array, Array, Array, Array, Array]:
    """Return middle, tangent, half length, width and arc length of the pieces of a stroke."""
    step = np.diff(stroke.points, axis=0)
    length = np.linalg.norm(step, axis=1)
    count = np.maximum(np.ceil(length / spacing), 1).astype(np.intp)
    segment = np.repeat(np.arange(len(count)), count)
    place = np.arange(len(segment)) - np.repeat(np.cumsum(count) - count, count)
    share = (place + 0.5) / count[segment]
    return (stroke.points[segment] + share[:, None] * step[segment],
            (step / length[:, None])[segment], (length / count / 2)[segment],
            stroke.widths[segment],
            stroke.arc_length[segment] + share * length[segment])
