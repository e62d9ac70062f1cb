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
    """Finds the layers of a growing path. What it costs follows from what is new."""

    def __init__(self) -> None:
        self._print_id = ''
        self._up: Plane | None = None
        self._begin('', None)

    def _begin(self, print_id: str, up: Plane | None) -> None:
        self._print_id, self._up = print_id, up
        # Of the known points:
        self._time, self._arc, self._height = np.empty(0), np.empty(0), np.empty(0)
        self._stroke, self._place = np.empty(0, np.intp), np.empty((0, 2))
        self._layer: list[int] = []
        self._rise: list[float] = []
        self._piece: list[int] = []  # the first point of the piece in which each is
        self._beside = BESIDE_M
        self._cells: dict[tuple[int, int], list[int]] = {}

    def layers(self, path: DepositionPath, stroke: Index, bed: Plane) -> Layering:
        """Return what each of N points of a path lies on.

        Args:
            path: N points.
            stroke: (N,) number of the stroke of each; 0 = travel.
            bed: plane of the bed; that of the print's first call tells which way is up.
        """
        if path.print_id != self._print_id or self._up is None:
            self._begin(path.print_id, bed)
            self._beside = max(BESIDE_M, SPACINGS * typical_spacing(path.points))
        assert self._up is not None
        known = self._same(path, stroke)
        self._forget_from(known)
        self._time, self._arc, self._stroke = path.time, path.arc_length, stroke
        new = path.points[known:]
        self._place = np.concatenate((self._place[:known], self._up.coordinates(new)))
        self._height = np.concatenate((self._height[:known], self._up.height(new)))
        for index in range(known, len(path)):
            self._add(index)
        return Layering(np.array(self._layer, np.intp), np.array(self._rise, np.float64))

    def _same(self, path: DepositionPath, stroke: Index) -> int:
        """Return how many points are as they were, up to the beginning of a piece that is not."""
        count = min(len(path), len(self._layer))
        other = np.flatnonzero((path.time[:count] != self._time[:count])
                               | (stroke[:count] != self._stroke[:count]))
        return self._piece[int(other[0])] if len(other) else count

    def _forget_from(self, count: int) -> None:
        for index in range(len(self._layer) - 1, count - 1, -1):
            cell = self._cells.get(self._cell(index), [])
            if cell and cell[-1] == index:
                cell.pop()
        del self._layer[count:], self._rise[count:], self._piece[count:]

    def _add(self, index: int) -> None:
        """Find what the next point lies on."""
        begins = (index == 0 or self._stroke[index] != self._stroke[index - 1]
                  or self._rises(index))
        first = index if begins else self._piece[-1]
        layer, rise = ON_TRAVEL, math.nan
        if self._stroke[index]:
            layer, rise = self._like_others(index) if begins else self._as_before()
            top = max(self._below(index), key=self._height.__getitem__, default=None)
            if top is not None and self._layer[top] + 1 >= layer:
                climbed, layer = layer, self._layer[top] + 1
                rise = float(self._height[index] - self._height[top])
                if (layer > climbed and self._piece[top] != first
                        and self._arc[index] - self._arc[first] < BRIDGE_M):
                    # It came upon ink: now it is known what it lies on from its beginning.
                    self._layer[first:] = [layer] * (index - first)
                    self._rise[first:] = [rise] * (index - first)
            self._cells.setdefault(self._cell(index), []).append(index)
        self._layer.append(layer)
        self._rise.append(rise)
        self._piece.append(first)

    def _as_before(self) -> tuple[int, float]:
        return self._layer[-1], self._rise[-1]

    def _rises(self, index: int) -> bool:
        """Return whether the path rises steeply to a point."""
        rise = float(self._height[index] - self._height[index - 1])
        return rise > STEEP * float(self._arc[index] - self._arc[index - 1])

    def _below(self, index: int) -> Iterator[int]:
        """Yield the earlier points right below a point."""
        u, v = self._cell(index)
        highest = self._height[index] - LEAST_RISE_M
        for column in range(u - 1, u + 2):
            for row in range(v - 1, v + 2):
                for other in self._cells.get((column, row), ()):
                    if (self._height[other] < highest
                            and math.dist(self._place[other], self._place[index]) < self._beside
                            and (self._stroke[other] != self._stroke[index]
                                 or self._arc[index] - self._arc[other] > OWN_WAY_M)):
                        yield other

    def _like_others(self, index: int) -> tuple[int, float]:
        """Return what a piece is taken to lie on until it comes upon ink.

        Ink right beside it tells, by its height. Else it is on the bed if it is as high as the
        first piece, or goes on in the layer of the piece before.
        """
        earlier = np.flatnonzero(self._stroke[:index] > 0)
        if not len(earlier):
            return 0, math.nan
        away = np.linalg.norm(self._place[earlier] - self._place[index], axis=1)
        other = int(earlier[np.argmin(away)])
        higher = float(self._height[index] - self._height[other])
        if away.min() < NEIGHBOUR_M and abs(higher) < LEAST_RISE_M + STEEPEST_BED * away.min():
            return self._layer[other], self._rise[other]
        if abs(self._height[index] - self._height[earlier[0]]) < LEAST_RISE_M:
            return 0, math.nan
        return self._layer[earlier[-1]], self._rise[earlier[-1]]

    def _cell(self, index: int) -> tuple[int, int]:
        u, v = self._place[index] / self._beside
        return math.floor(u), math.floor(v)
