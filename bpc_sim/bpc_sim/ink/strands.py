"""The nearest point of a curve, exact and vectorised, strand by strand.

A curve is cut into strands that turn by a quarter circle at most, so that a point near a strand
has one foot on it; neighbouring turns of a spiral are different strands and are looked at
separately. On a strand the nearest of dense samples is found by a k-d tree and the foot on the
osculating circle there in closed form; what is neglected, the change of curvature over half a
sample step, is a nanometre across the path and some ten along it.
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

STEP = 5e-5  # between samples [m]


@dataclass(frozen=True, eq=False)
class Strand:
    """A piece of a curve between two arc lengths, with K samples.

    Attributes:
        start, end: arc lengths that it spans [m]; at the ends of an open curve, infinite.
        s: (K,) arc lengths of the samples [m].
        points: (K, 2) samples [m].
        heading: (K,) angle of the tangent [rad].
        curvature: (K,) [1/m], positive to the left.
        tree: of the points.
    """

    start: float
    end: float
    s: Array
    points: Array
    heading: Array
    curvature: Array
    tree: cKDTree

    def near(self, points: Array, reach: float) -> NDArray[np.intp]:
        """Indices of points (N, 2) within ``reach`` [m] of the strand's bounding box."""
        low, high = self.points.min(axis=0) - reach, self.points.max(axis=0) + reach
        x, y = points[:, 0], points[:, 1]
        return np.flatnonzero((x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1]))

    def feet(self, points: Array) -> tuple[Array, Array, Array]:
        """Feet of N groups of M points (N, M, 2) [m]; a group is small: one search serves it.

        Returns:
            s: (N, M) arc length of the foot [m], beyond the ends by extrapolation.
            offset: (N, M) signed distance from it, positive to the left [m].
            heading: (N, M) angle of the tangent there [rad].
        """
        _, nearest = self.tree.query(points.mean(axis=1))
        heading = self.heading[nearest][:, None]
        curvature = self.curvature[nearest][:, None]
        dx, dy = np.moveaxis(points - self.points[nearest][:, None], 2, 0)
        cos, sin = np.cos(heading), np.sin(heading)
        along, across = cos * dx + sin * dy, cos * dy - sin * dx
        # The circle's centre is at 1 / curvature across; both forms hold for a straight line.
        opposite, adjacent = curvature * along, 1 - curvature * across
        turn = np.arctan2(opposite, adjacent)
        offset = ((2 * across - curvature * (along**2 + across**2))
                  / (1 + np.hypot(opposite, adjacent)))
        straight = np.abs(curvature) < 1e-6
        travel = np.where(straight, along, turn / np.where(straight, 1.0, curvature))
        return self.s[nearest][:, None] + travel, offset, heading + turn


@lru_cache(maxsize=16)
def strands(curve: Curve) -> tuple[Strand, ...]:
    """Cut a curve where its curvature jumps and after every quarter turn."""
    pieces = []
    breaks = (0.0, *curve.breaks, curve.length)
    for start, end in pairwise(breaks):
        count = max(int(np.ceil((end - start) / STEP)), 2)
        borders = np.linspace(start, end, count + 1)
        # Of the inside of the piece: at its very ends the curve belongs to the next one too.
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
            Strand(_extend(float(borders[i]), curve), _extend(float(borders[j]), curve),
                   s[i:j], points[i:j], heading[i:j], curvature[i:j], cKDTree(points[i:j]))
            for i, j in pairwise(cuts)]
    return tuple(pieces)


def _extend(s: float, curve: Curve) -> float:
    """The same arc length, but infinite where the curve ends, unless it goes on there."""
    if curve.closed:
        return s
    return -np.inf if s <= 0 else np.inf if s >= curve.length else s
