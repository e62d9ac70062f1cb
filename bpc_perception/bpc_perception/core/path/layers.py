"""Layers: how many strokes lie below each place of a path, known before a pixel is read.

A stroke lies on an earlier one where the nozzle passes over it, higher by a layer or so. Between
such places it is in the same layer, as a strand that bridges a pore. Passes at the same height are
of the same layer, whether or not they cross. Heights are compared over short distances only, so
beds may be tilted or curved.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
import math

import numpy as np

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.filters import places_of
from bpc_perception.core.geometry import Plane
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.tangents import typical_spacing

ON_TRAVEL = -1
LEAST_RISE_M = 1e-4  # of a layer; the lowest in use are twice as high
# So near to each other, places of two passes are above each other, or in spacings of the path:
BESIDE_M, SPACINGS = 3e-4, 0.75
OWN_WAY_M = 2e-3  # a path so much later may lie on itself, as a helix does
STEEP = 0.5  # a path that rises by more, per length, goes from one layer to the next
BRIDGE_M = 0.01  # of a stroke before the first ink that it lies on, at most
NEIGHBOUR_M = 1e-3  # ink so near tells the layer of a stroke that begins beside it
STEEPEST_BED = 0.3  # rise per length
LEAST_ALIKE = math.cos(0.1)  # of the normals of a bed; else the earlier was none of it


@dataclass(frozen=True)
class Layering:
    """What N points of a path lie on.

    Attributes:
        layer: (N,) 0 = on the bed, 1 = on one stroke, ...; ON_TRAVEL = no ink is laid.
        rise: (N,) how much higher the nozzle passed than over what the point lies on [m]; NaN = it
            lies on the bed.
    """

    layer: Index
    rise: Array


class LayerFinder:
    """Finds the layers of a growing path. What it costs follows from what is new.

    Points keep what was found of them, though the beginning of a stroke may be told anew.
    """

    def __init__(self) -> None:
        self._begin('', None)

    def _begin(self, print_id: str, up: Plane | None) -> None:
        self._print_id, self._up = print_id, up
        self._time, self._order = np.empty(0), np.empty(0, np.intp)  # sorted, and whose they are
        # Of the known points of strokes, in the order in which they became known:
        self._place: list[list[float]] = []  # along the bed [m]
        self._cell: list[list[int]] = []  # column and row of the square of ``_beside`` it is in
        self._height: list[float] = []  # above the bed [m]
        self._lowest = math.inf  # of these heights
        self._arc: list[float] = []  # arc length [m]
        self._piece: list[int] = []  # the first point of the piece in which each is
        self._layer: list[int] = []
        self._rise: list[float] = []
        self._beside = BESIDE_M
        self._cells: dict[tuple[int, int], list[int]] = {}  # the points in each square

    def layers(self, path: DepositionPath, stroke: Index, bed: Plane) -> Layering:
        """Return what each of N points of a path lies on.

        Args:
            path: N points.
            stroke: (N,) number of the stroke of each; 0 = travel.
            bed: plane of the bed; that of the print's first call tells which way is up, as long
                as those of later ones are about the same.
        """
        if (path.print_id != self._print_id or self._up is None
                or self._up.normal @ bed.normal < LEAST_ALIKE):
            self._begin(path.print_id, bed)
            self._beside = max(BESIDE_M, SPACINGS * typical_spacing(path.points))
        assert self._up is not None
        laid = np.flatnonzero(stroke > 0)
        known = self._known(path.time[laid])
        new = np.flatnonzero(known < 0)
        self._see(path.points[laid[new]], path.arc_length[laid[new]], self._up)
        follows = np.append(False, (np.diff(laid) == 1) & (np.diff(stroke[laid]) == 0))
        for each in new.tolist():
            known[each] = self._add(int(known[each - 1]) if follows[each] else None)
        self._remember(path.time[laid[new]], known[new])
        layer, rise = np.full(len(path), ON_TRAVEL, np.intp), np.full(len(path), np.nan)
        layer[laid] = np.array(self._layer, np.intp)[known]
        rise[laid] = np.array(self._rise)[known]
        return Layering(layer, rise)

    def _known(self, time: Array) -> Index:
        """Return which known point each time (K,) is of; -1 = none."""
        place = places_of(self._time, time)
        found = place >= 0
        place[found] = self._order[place[found]]
        return place

    def _remember(self, time: Array, number: Index) -> None:
        """Remember the times (K,) of new points by their numbers (K,)."""
        time, number = np.append(self._time, time), np.append(self._order, number)
        order = np.argsort(time, kind='stable')
        self._time, self._order = time[order], number[order]

    def _see(self, points: Array, arc: Array, up: Plane) -> None:
        """Note where new points (K, 3) lie [m], at arc lengths (K,) [m]."""
        place, height = up.coordinates(points), up.height(points)
        self._place += place.tolist()
        self._cell += np.floor(place / self._beside).astype(np.intp).tolist()
        self._height += height.tolist()
        self._lowest = min(self._lowest, float(height.min(initial=math.inf)))
        self._arc += arc.tolist()

    def _add(self, before: int | None) -> int:
        """Find what the next of the points lies on; return its number.

        ``before`` is the number of the point before it on the same stroke; None = it begins one.
        """
        number = len(self._layer)
        height, arc = self._height[number], self._arc[number]
        if before is not None:
            risen, gone = height - self._height[before], arc - self._arc[before]
            before = None if risen > STEEP * gone else before  # the next layer begins
        first = number if before is None else self._piece[before]
        self._piece.append(first)
        layer, rise = (self._like_others(number) if before is None
                       else (self._layer[before], self._rise[before]))
        self._layer.append(layer)
        self._rise.append(rise)
        top = self._top_below(number)
        if top is not None and self._layer[top] + 1 >= layer:
            came_upon = (self._layer[top] + 1 > layer and self._piece[top] != first
                         and arc - self._arc[first] < BRIDGE_M)
            layer, rise = self._layer[top] + 1, height - self._height[top]
            # If it came upon ink now, it is known what it lies on from its beginning.
            for each in range(first if came_upon else number, number + 1):
                if self._piece[each] == first:
                    self._layer[each], self._rise[each] = layer, rise
        u, v = self._cell[number]
        self._cells.setdefault((u, v), []).append(number)
        return number

    def _top_below(self, number: int) -> int | None:
        """Return the highest of the earlier points right below a point; None = there is none."""
        if self._lowest >= self._height[number] - LEAST_RISE_M:  # as all along the first layer
            return None
        return max(self._below(number), key=self._height.__getitem__, default=None)

    def _below(self, number: int) -> Iterator[int]:
        """Yield the earlier points right below a point."""
        u, v = self._cell[number]
        highest = self._height[number] - LEAST_RISE_M
        for column in range(u - 1, u + 2):
            for row in range(v - 1, v + 2):
                for other in self._cells.get((column, row), ()):
                    if (self._height[other] < highest
                            and math.dist(self._place[other], self._place[number]) < self._beside
                            and (self._piece[other] != self._piece[number]
                                 or self._arc[number] - self._arc[other] > OWN_WAY_M)):
                        yield other

    def _like_others(self, number: int) -> tuple[int, float]:
        """Return what a piece is taken to lie on until it comes upon ink.

        Ink right beside it tells, by its height: no bed rises so steeply as to the next layer of
        one that leans. Else it is on the bed if it is as high as the first piece, or goes on in
        the layer of the piece before.
        """
        if not number:
            return 0, math.nan
        away = np.linalg.norm(np.array(self._place[:number]) - self._place[number], axis=1)
        near = np.flatnonzero(away < NEIGHBOUR_M)
        if len(near):
            higher = self._height[number] - np.array(self._height[:number])[near]
            bed_may_rise = LEAST_RISE_M + STEEPEST_BED * away[near]
            nearest = int(np.argmin(away[near]))
            if abs(higher[nearest]) < bed_may_rise[nearest]:
                return self._layer[near[nearest]], self._rise[near[nearest]]
            below = np.where(higher > bed_may_rise, higher, np.inf)
            top = int(np.argmin(below))
            if np.isfinite(below[top]):
                return self._layer[near[top]] + 1, float(higher[top])
        if abs(self._height[number] - self._height[0]) < LEAST_RISE_M:
            return 0, math.nan
        return self._layer[number - 1], self._rise[number - 1]
