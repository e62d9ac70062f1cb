"""The side points of a path, as either method finds them."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from bpc_perception.core.arrays import Array, Index


@dataclass(frozen=True)
class SidePoints:
    """For each of N path points the nearest edge of the ink on either side; NaN = none.

    Attributes:
        left, right: (N, 3) the side points in the base frame [m].
        left_distance, right_distance: (N,) their distances from the path, along the surface and
            across the direction of travel [m].
    """

    left: Array
    right: Array
    left_distance: Array
    right_distance: Array

    def arrays(self) -> list[Array]:
        """Return all arrays, in the order of the attributes."""
        return [getattr(self, field.name) for field in fields(self)]

    def at(self, place: Array) -> SidePoints:
        """Return the side points at places (K,), which are fractions of an index."""
        return SidePoints(*(interpolated(values, place) for values in self.arrays()))


def interpolated(values: Array, place: Array) -> Array:
    """Return values (N, ...) at places (K,), linear between two of them.

    Beside NaN the nearest value counts.
    """
    low = np.minimum(place.astype(np.intp), len(values) - 1)
    high = np.minimum(low + 1, len(values) - 1)
    share = (place - low).reshape(-1, *(1,) * (values.ndim - 1))
    share = np.where(low == high, 0.0, share.T).T
    with np.errstate(invalid='ignore'):  # beside infinity the nearest counts as well
        mixed = (1 - share) * values[low] + share * values[high]
    return np.asarray(np.where(np.isnan(mixed), values[nearest(place, len(values))], mixed))


def nearest(place: Array, count: int) -> Index:
    """Return which of ``count`` values is nearest to each place (K,)."""
    return np.minimum(np.rint(place).astype(np.intp), count - 1)
