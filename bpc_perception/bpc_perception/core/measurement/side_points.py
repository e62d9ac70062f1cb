"""The side points of a path, as either method finds them, and how columns of it are handled."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array, Index

Own = TypeVar('Own', bound='Columns')


@dataclass(frozen=True)
class Columns:
    """Arrays with one entry a path point each, as the fields of a subclass."""

    def arrays(self) -> list[Array]:
        """Return all arrays, in the order of the attributes."""
        return [getattr(self, field.name) for field in fields(self)]

    def of(self: Own, index: Index) -> Own:
        """Return the entries of an index (K,)."""
        return type(self)(*(values[index] for values in self.arrays()))

    def at(self: Own, place: Array) -> Own:
        """Return the entries at places (K,), which are fractions of an index."""
        return type(self)(*(interpolated(values, place) for values in self.arrays()))

    def with_part(self: Own, index: Index, part: Own) -> Own:
        """Return these entries with those of an index (K,) replaced by a part (K,)."""
        return type(self)(*(replaced(old, index, new) for old, new in zip(
            self.arrays(), part.arrays(), strict=True)))


@dataclass(frozen=True)
class SidePoints(Columns):
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

    @property
    def width(self) -> Array:
        """Of the ink between them (N,) [m]."""
        return self.left_distance + self.right_distance


def replaced(values: NDArray[Any], index: Index, part: NDArray[Any]) -> NDArray[Any]:
    """Return values (N, ...) with those of an index (K,) replaced by a part (K, ...)."""
    changed = values.copy()
    changed[index] = part
    return changed


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
