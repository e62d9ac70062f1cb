"""The nearest point of a curve, exact and vectorised, piece by piece.

A curve is cut into pieces that turn by at most a quarter circle. A point near a piece thus has
one foot on it, and neighbouring turns of a spiral are different pieces, which are searched
separately. On a piece a k-d tree finds the nearest of dense samples; the foot on the osculating
circle there follows in closed form. This neglects the change of curvature over half a sample
step: a nanometre across the path and some ten nanometres along it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array
from bpc_sim.ink.curves import Curve

SAMPLE_STEP_M = 5e-5
SEAM_M = 1e-9  # pieces overlap by this much, so that rounding leaves no cracks between them
STRAIGHT_PER_M = 1e-6  # a smaller curvature is that of a straight line


@dataclass(frozen=True, eq=False)
class Feet:
    """Feet of points on a piece of a curve; arrays (N, M).

    Attributes:
        s: arc length of the foot [m]; extrapolated beyond the ends.
        offset: signed distance of the point from the foot, positive to the left [m].
        heading: angle of the tangent at the foot [rad].
    """

    s: Array
    offset: Array
    heading: Array


@dataclass(frozen=True, eq=False)
class CurvePiece:
    """A piece of a curve between two arc lengths, with K samples.

    Attributes:
        start, end: arc lengths that it spans [m]; infinite at the ends of an open curve.
        s: (K,) arc lengths of the samples [m].
        points: (K, 2) samples [m].
        heading: (K,) angle of the tangent [rad].
        curvature: (K,) [1/m], positive to the left.
        tree: k-d tree of the samples.
    """

    start: float
    end: float
    s: Array
    points: Array
    heading: Array
    curvature: Array
    tree: cKDTree

    def near(self, points: Array, reach: float) -> NDArray[np.intp]:
        """Return the indices of points (N, 2) within ``reach`` [m] of the bounding box."""
        low, high = self.points.min(axis=0) - reach, self.points.max(axis=0) + reach
        x, y = points[:, 0], points[:, 1]
        return np.flatnonzero((x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1]))

    def spans(self, s: Array) -> NDArray[np.bool_]:
        """Tell which arc lengths [m], of any shape, lie on this piece."""
        return np.asarray((s >= self.start - SEAM_M) & (s <= self.end + SEAM_M))

    def feet(self, points: Array) -> Feet:
        """Find the feet of N groups of M points (N, M, 2) [m].

        A group is so small that one search serves all its points.
        """
        _, nearest = self.tree.query(points.mean(axis=1))
        heading = self.heading[nearest][:, None]
        curvature = self.curvature[nearest][:, None]
        dx, dy = np.moveaxis(points - self.points[nearest][:, None], 2, 0)
        cos, sin = np.cos(heading), np.sin(heading)
        along, across = cos * dx + sin * dy, cos * dy - sin * dx
        # The circle's centre is 1 / curvature across; both forms hold for a straight line too.
        opposite, adjacent = curvature * along, 1 - curvature * across
        turn = np.arctan2(opposite, adjacent)
        offset = ((2 * across - curvature * (along**2 + across**2))
                  / (1 + np.hypot(opposite, adjacent)))
        straight = np.abs(curvature) < STRAIGHT_PER_M
        travel = np.where(straight, along, turn / np.where(straight, 1.0, curvature))
        return Feet(self.s[nearest][:, None] + travel, offset, heading + turn)


@lru_cache(maxsize=16)
def curve_pieces(curve: Curve) -> tuple[CurvePiece, ...]:
    """Cut a curve where its curvature jumps and after every quarter turn."""
    pieces = []
    breaks = (0.0, *curve.breaks, curve.length)
    for start, end in pairwise(breaks):
        count = max(int(np.ceil((end - start) / SAMPLE_STEP_M)), 2)
        borders = np.linspace(start, end, count + 1)
        # Tangents inside the piece: at its very ends the curve belongs to the next piece too.
        inset = 1e-6 * (borders[1] - borders[0])
        tangents = curve.tangents(np.clip(borders, start + inset, end - inset))
        turned = np.unwrap(np.arctan2(tangents[:, 1], tangents[:, 0]))
        s = (borders[1:] + borders[:-1]) / 2
        points, tangents = curve.locus(s)
        heading = np.arctan2(tangents[:, 1], tangents[:, 0])
        curvature = np.diff(turned) / np.diff(borders)
        quarter = np.floor(np.cumsum(np.abs(np.diff(turned))) / (np.pi / 2))
        cuts = [0, *(np.flatnonzero(np.diff(quarter)) + 1).tolist(), count]
        pieces += [
            CurvePiece(_extend(float(borders[i]), curve), _extend(float(borders[j]), curve),
                       s[i:j], points[i:j], heading[i:j], curvature[i:j],
                       cKDTree(points[i:j]))
            for i, j in pairwise(cuts)]
    return tuple(pieces)


def _extend(s: float, curve: Curve) -> float:
    """Return an arc length [m], made infinite at the ends of an open curve."""
    if curve.closed:
        return s
    return -np.inf if s <= 0 else np.inf if s >= curve.length else s
