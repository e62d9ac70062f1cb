"""What a method finds out about the samples of a path."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.measurement.side_points import (
    Columns,
    interpolated,
    nearest,
    replaced,
    SidePoints,
)
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.profile import Cause, Status, StatusArray


@dataclass(frozen=True)
class Sizes(Columns):
    """How much ink lies at each of N path points; NaN = not known.

    Attributes:
        crest, crest_sigma: (N,) height of the ink above its side points, with its 1-sigma
            uncertainty [m].
        height, height_sigma: (N,) of the ink above the surface before [m].
        area, area_sigma: (N,) of its cross-section above the surface before [m^2].
    """

    crest: Array
    crest_sigma: Array
    height: Array
    height_sigma: Array
    area: Array
    area_sigma: Array

    @classmethod
    def unknown(cls, count: int) -> Sizes:
        """Return sizes of which nothing is known."""
        return cls(*[np.full(count, np.nan)] * len(fields(cls)))


@dataclass(frozen=True)
class Samples:
    """What is known of N path points. The arrays must not be changed.

    Attributes:
        sides: the side points.
        verdicts: what is known of them.
        sigma: (N,) 1-sigma uncertainty of the width between the side points [m].
        sizes: height and cross-section.
        seen_in: (N,) number of the capture that it was found in; -1 = none.
    """

    sides: SidePoints
    verdicts: Verdicts
    sigma: Array
    sizes: Sizes
    seen_in: Index

    @property
    def status(self) -> StatusArray:
        """(N,) values of Status."""
        return self.verdicts.status

    def of(self, index: Index) -> Samples:
        """Return the samples of an index (K,)."""
        return Samples(self.sides.of(index), self.verdicts.of(index), self.sigma[index],
                       self.sizes.of(index), self.seen_in[index])

    def at(self, place: Array) -> Samples:
        """Return the samples at places (K,), which are fractions of an index."""
        near = nearest(place, len(self.status))
        return Samples(self.sides.at(place), self.verdicts.of(near),
                       interpolated(self.sigma, place), self.sizes.at(place), self.seen_in[near])

    def with_part(self, index: Index, part: Samples) -> Samples:
        """Return these samples with those of an index (K,) replaced by a part (K,)."""
        return Samples(self.sides.with_part(index, part.sides),
                       self.verdicts.with_part(index, part.verdicts),
                       replaced(self.sigma, index, part.sigma),
                       self.sizes.with_part(index, part.sizes),
                       replaced(self.seen_in, index, part.seen_in))


def unseen(count: int) -> Samples:
    """Return samples of which nothing is known."""
    blank = np.full((count, 3), np.nan)
    return Samples(SidePoints(blank, blank, blank[:, 0], blank[:, 0]),
                   Verdicts.all_of(count, Status.NO_DATA, Cause.OUTSIDE_IMAGE), blank[:, 0],
                   Sizes.unknown(count), np.full(count, -1))
