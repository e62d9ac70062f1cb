"""What a method finds out about the samples of a path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.measurement.side_points import interpolated, nearest, SidePoints
from bpc_perception.core.profile import Status, StatusArray


@dataclass(frozen=True)
class Samples:
    """What is known of N path points. The arrays must not be changed.

    Attributes:
        sides: the side points.
        status: (N,) values of Status.
        sigma: (N,) 1-sigma uncertainty of the width between the side points [m].
    """

    sides: SidePoints
    status: StatusArray
    sigma: Array

    def of(self, index: Index) -> Samples:
        """Return the samples of an index (K,)."""
        return Samples(SidePoints(*(values[index] for values in self.sides.arrays())),
                       self.status[index], self.sigma[index])

    def at(self, place: Array) -> Samples:
        """Return the samples at places (K,), which are fractions of an index."""
        return Samples(self.sides.at(place), self.status[nearest(place, len(self.status))],
                       interpolated(self.sigma, place))

    def with_part(self, index: Index, part: Samples) -> Samples:
        """Return these samples with those of an index (K,) replaced by a part (K,)."""
        sides = [values.copy() for values in self.sides.arrays()]
        for values, new in zip(sides, part.sides.arrays(), strict=True):
            values[index] = new
        status, sigma = self.status.copy(), self.sigma.copy()
        status[index], sigma[index] = part.status, part.sigma
        return Samples(SidePoints(*sides), status, sigma)


def unseen(count: int) -> Samples:
    """Return samples of which nothing is known."""
    blank = np.full((count, 3), np.nan)
    return Samples(SidePoints(blank, blank, blank[:, 0], blank[:, 0]),
                   np.full(count, Status.NO_DATA, np.uint8), blank[:, 0])
