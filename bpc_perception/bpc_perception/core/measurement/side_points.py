"""The side points of a profile, found by either method."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from bpc_perception.core.arrays import Array, Index


@dataclass(frozen=True)
class SidePoints:
    """For each of N path points the nearest contour points on either side; NaN = none.

    Attributes:
        left, right: (N, 3) the side points.
        left_distance, right_distance: (N,) how far they lie from the path, along the surface
            and across the direction of travel [m].
    """

    left: Array
    right: Array
    left_distance: Array
    right_distance: Array

    def between(self, place: Array) -> SidePoints:
        """At places (K,) between the path points, as fractions of an index."""
        return SidePoints(*(between(getattr(self, field.name), place) for field in fields(self)))


def between(values: Array, place: Array) -> Array:
    """Values (N, ...) at places (K,) between them; next to NaN the nearest counts."""
    low = np.minimum(place.astype(np.intp), len(values) - 1)
    high = np.minimum(low + 1, len(values) - 1)
    share = (place - low).reshape(-1, *(1,) * (values.ndim - 1))
    share = np.where(low == high, 0.0, share.T).T
    mixed = (1 - share) * values[low] + share * values[high]
    return np.asarray(np.where(np.isnan(mixed), values[nearest(place, len(values))], mixed))


def nearest(place: Array, count: int) -> Index:
    """Which of so many values is nearest to each place (K,)."""
    return np.minimum(np.rint(place).astype(np.intp), count - 1)
