"""Factors on the flow along a path that is to be printed again."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.arrays import Array


@dataclass(frozen=True)
class RateSchedule:
    """Factors at K places along a layer, and times of the extruder's switches.

    Attributes:
        place: (K,) arc length from the layer's first ink on [m].
        factor: (K,) on the flow that the first layer learned from began with, per length of path.
        sigma: standard deviation of the logarithm of the factor at a place.
        level_sigma: the same of all factors together.
        volume: (K,) to be commanded per length of path: the factor times the reference.
        reference: volume per length to which the factors refer [m^2], or travel of the plunger per
            length where no flow is known.
        advance: how long before each stroke the extruder is to be switched on [s].
        retreat: how long before each stroke's end it is to be switched off [s].
        layers: number of layers learned from.
    """

    place: Array
    factor: Array
    sigma: float
    level_sigma: float
    volume: Array
    reference: float
    advance: float
    retreat: float
    layers: int

    def at(self, place: Array | float) -> Array:
        """Return the factors (...) at places (...) [m]; those of the ends beyond them."""
        return np.asarray(np.interp(place, self.place, self.factor))

    def until(self, place: float) -> RateSchedule:
        """Return the part up to a place [m]."""
        kept = self.place <= place
        return replace(self, place=self.place[kept], factor=self.factor[kept],
                       volume=self.volume[kept])
