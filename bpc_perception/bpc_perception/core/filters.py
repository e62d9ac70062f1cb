"""Medians and means of arrays with unknown values, and in pieces that must not be mixed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bpc_perception.core.arrays import Array, Flags, Index


def masked_median(values: NDArray[np.floating[Any]], mask: Flags) -> Array:
    """Return the medians (N, ...) of masked values over their second axis.

    Args:
        values: (N, M, ...) numbers.
        mask: (N, M) which of them count; NaN is the median of none.
    """
    if not values.shape[1]:
        return np.full((len(values), *values.shape[2:]), np.nan)
    # Values that are compared lie side by side in memory, which makes sorting fast.
    ordered = np.moveaxis(values, 1, -1).copy()
    shown = mask.reshape(len(mask), *(1,) * (values.ndim - 2), -1)
    np.copyto(ordered, np.inf, where=~shown)
    ordered.sort(axis=-1)
    count = np.count_nonzero(mask, axis=1)
    low, high = np.maximum(count - 1, 0) // 2, np.minimum(count // 2, values.shape[1] - 1)
    row = np.arange(len(values))
    middle = (ordered[row, ..., low] + ordered[row, ..., high]) / 2
    middle[count == 0] = np.nan
    return np.asarray(middle, np.float64)


def runs(piece: Index) -> tuple[Index, Index]:
    """Return the first index of the run of equal numbers around each (N,), and that behind it."""
    begins = _begins(piece)
    borders = np.append(begins, len(piece))
    length = np.diff(borders)
    return np.repeat(begins, length), np.repeat(borders[1:], length)


def _begins(piece: Index) -> Index:
    """Return the first index (R,) of each run of equal numbers (N,)."""
    return np.flatnonzero(np.concatenate(([True], piece[1:] != piece[:-1])))[:len(piece)]


def thinned(piece: Index, step: int) -> Index:
    """Return the index (K,) of every ``step``-th row of each piece (N,), and of its last."""
    first, end = runs(piece)
    row = np.arange(len(piece))
    return np.flatnonzero(((row - first) % step == 0) | (row == end - 1))


def running_median(values: Array, window: int, piece: Index) -> Array:
    """Return the running medians (N, ...) of values (N, ...) over ``window`` neighbours.

    Neighbours are of the same piece (N,), as numbered. NaN is replaced first, linearly between the
    known values around and by the nearest at the ends. A column of NaN alone stays NaN.
    """
    columns = values.reshape(len(values), -1)
    result = np.empty_like(columns)
    index = np.arange(len(values))
    begins = _begins(piece)
    for number, column in enumerate(columns.T):
        known = np.flatnonzero(np.isfinite(column))
        if len(known) == 0:
            result[:, number] = np.nan
            continue
        filled = column if len(known) == len(column) else np.interp(index, known, column[known])
        result[:, number] = _filtered_in_pieces(filled, window, begins)
    return result.reshape(values.shape)


def windows_around(piece: Index, reach: int) -> tuple[Index, Index]:
    """Return the first row up to ``reach`` before each (N,), and that behind the last as far on.

    Rows are of the same piece (N,).
    """
    first, end = runs(piece)
    row = np.arange(len(piece))
    return np.maximum(row - reach, first), np.minimum(row + reach + 1, end)


def window_sums(values: Array, window: tuple[Index, Index]) -> Array:
    """Return the sums (N, K) of values (N, K) from the first row of each window to its end."""
    total = np.zeros((len(values) + 1, values.shape[1]))
    np.cumsum(values, axis=0, out=total[1:])
    return np.asarray(total[window[1]] - total[window[0]])


def places_of(known: Array, asked: Array) -> Index:
    """Return at which place of increasing numbers (K,) each of others (N,) is; -1 = nowhere."""
    if not len(known):
        return np.full(len(asked), -1)
    place = np.minimum(np.searchsorted(known, asked), len(known) - 1)
    return np.where(known[place] == asked, place, -1)


def near_any(arc: Array, places: Array, reach: float) -> Flags:
    """Return which of increasing arc lengths (N,) are within a reach of any place (K,) [m]."""
    near = np.zeros(len(arc) + 1)
    np.add.at(near, np.searchsorted(arc, places - reach), 1)
    np.add.at(near, np.searchsorted(arc, places + reach, side='right'), -1)
    return np.asarray(np.cumsum(near)[:-1] > 0)


def running_mean(values: Array, window: int, piece: Index) -> Array:
    """Return the mean of the known values (N, K) over ``window`` neighbours.

    Neighbours are of the same piece (N,). NaN where none of them is known.
    """
    around, known = windows_around(piece, window // 2), np.isfinite(values)
    total, among = (window_sums(kind, around) for kind in (np.where(known, values, 0.0), known))
    return np.divide(total, among, out=np.full(values.shape, np.nan), where=among > 0)


def last_true(flags: Flags) -> Index:
    """Return where (N,) the last True is in each row (N, K); -1 = nowhere."""
    return np.where(flags.any(axis=1), flags.shape[1] - 1 - np.argmax(flags[:, ::-1], axis=1), -1)


def _filtered_in_pieces(values: Array, window: int, begins: Index) -> Array:
    """Return the running median of values (N,) in pieces that begin at an index (S,)."""
    if len(begins) == 1:
        return _filtered(values, min(window, len(values)))
    borders = np.append(begins, len(values))
    length = np.diff(borders)
    result = np.empty_like(values)
    for start, end in zip(borders[:-1][length < window], borders[1:][length < window],
                          strict=True):
        result[start:end] = _filtered(values[start:end], int(end - start))
    long = np.flatnonzero(length >= window)
    if len(long):
        # One pass over all: between pieces, their ends are repeated as far as a window reaches.
        half = window // 2
        place = np.concatenate([np.arange(borders[one] - half, borders[one + 1] + half)
                                for one in long])
        piece = np.repeat(long, length[long] + 2 * half)
        inner = np.clip(place, borders[piece], borders[piece + 1] - 1)
        own = inner == place
        result[place[own]] = _filtered(values[inner], window)[own]
    return result


def _filtered(values: Array, window: int) -> Array:
    """Return the running median of values (N,); the first and last values extend the ends."""
    return np.asarray(median_filter(values, size=window, mode='nearest'))
