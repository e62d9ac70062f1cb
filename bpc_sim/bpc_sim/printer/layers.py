"""What each layer lies on: the foot of its strands, which rest on those below and sag between.

A strand whose way crosses those of the layer below rests where it crosses them, a layer's height
above their own feet, and hangs between: a parabola, as of a thread under its weight. One that runs
along a strand below, or on the bed, lies on it all along.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Index
from bpc_sim.ink.deposit import WidthProfile

STEP_M = 1e-4  # between the places of a strand at which its foot is tabulated


@dataclass(frozen=True, eq=False)
class Strands:
    """The straight strands of a print in layers.

    Attributes:
        lines: (S, 2, 2) start and end of each, in the order in which they are laid [m].
        layer: (S,) layer of each; 0 = on the bed.
        layer_height: from one layer to the next [m].
        sag: how far a strand hangs down in the middle between two supports [m].
    """

    lines: Array
    layer: Index
    layer_height: float
    sag: float = 0.0

    @property
    def arcs(self) -> Array:
        """Arc lengths (S, 2) of start and end of each strand on the path through all [m]."""
        ends = self.lines.reshape(-1, 2)
        legs = np.linalg.norm(np.diff(ends, axis=0), axis=1)
        return np.concatenate(([0.0], np.cumsum(legs))).reshape(-1, 2)

    @property
    def layer_arcs(self) -> Array:
        """Arc lengths (L, 2) between which each layer is laid [m]."""
        arcs = self.arcs
        return np.array([(arcs[self.layer == number].min(), arcs[self.layer == number].max())
                         for number in np.unique(self.layer)])

    @property
    def rises(self) -> Array:
        """How much higher each strand but the first is laid than the one before (S - 1,) [m]."""
        return np.diff(self.layer) * self.layer_height

    def feet(self) -> WidthProfile:
        """Return the height of the foot above the bed over arc length [m]."""
        places, heights = [], []
        for number, (start, end) in enumerate(self.arcs.tolist()):
            steps = np.linspace(0.0, end - start, max(2, round((end - start) / STEP_M)))
            along = np.union1d(steps, self._crossings(number))
            # A strand ends where it ends, however near the next begins.
            places.append(start + along + (1e-9, *np.zeros(len(along) - 2), -1e-9))
            heights.append(self.layer[number] * self.layer_height - self._hanging(number, along))
        place, height = np.concatenate(places), np.concatenate(heights)
        return lambda s: np.interp(s, place, height)

    def _hanging(self, number: int, along: Array) -> Array:
        """Return how far a strand hangs down (K,) at distances from its start (K,) [m]."""
        rests = np.sort(self._crossings(number))
        if len(rests) < 2:
            return np.zeros(len(along))
        span = np.clip(np.searchsorted(rests, along) - 1, 0, len(rests) - 2)
        part = (along - rests[span]) / (rests[span + 1] - rests[span])
        return np.where((part > 0) & (part < 1), 4 * self.sag * part * (1 - part), 0.0)

    def _crossings(self, number: int) -> Array:
        """Return how far from its start a strand crosses those of the layer below (K,) [m]."""
        start, end = self.lines[number]
        way = end - start
        found = []
        for other in self.lines[self.layer == self.layer[number] - 1]:
            there = other[1] - other[0]
            turned = way[0] * there[1] - way[1] * there[0]
            if abs(turned) < 1e-12:  # side by side, or one on the other
                continue
            off = other[0] - start
            own, its = ((off[0] * along[1] - off[1] * along[0]) / turned for along in (there, way))
            if 0 <= own <= 1 and 0 <= its <= 1:
                found.append(own * np.linalg.norm(way))
        return np.array(found)
