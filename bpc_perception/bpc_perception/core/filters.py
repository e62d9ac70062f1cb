"""Medians of arrays with unknown values."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bpc_perception.core.arrays import Array, Flags

LONGEST_SORTED_WINDOW = 19  # up to which sorting is quicker than a filter [values]


def masked_median(values: NDArray[np.floating[Any]], mask: Flags) -> Array:
    """Return the medians (N, ...) of masked values over their second axis.

    Args:
        values: (N, M, ...) numbers.
        mask: (N, M) which of them count; NaN is the median of none.
    """
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


def running_median(values: Array, window: int) -> Array:
    """Return the running medians (N, ...) of values (N, ...) over ``window`` neighbours.

    NaN is replaced first, linearly between the known values around and by the nearest at the
    ends. A column of NaN alone stays NaN.
    """
    columns = values.reshape(len(values), -1)
    result = np.empty_like(columns)
    index = np.arange(len(values))
    window = min(window, len(values))
    for number, column in enumerate(columns.T):
        known = np.flatnonzero(np.isfinite(column))
        if len(known) == 0:
            result[:, number] = np.nan
            continue
        filled = column if len(known) == len(column) else np.interp(index, known, column[known])
        result[:, number] = _filtered(filled, window)
    return result.reshape(values.shape)


def _filtered(values: Array, window: int) -> Array:
    """Return the running median of values (N,); the first and last values extend the ends."""
    if window % 2 == 0 or window > LONGEST_SORTED_WINDOW:
        return np.asarray(median_filter(values, size=window, mode='nearest'))
    half = window // 2
    padded = np.concatenate((np.full(half, values[0]), values, np.full(half, values[-1])))
    windows = sliding_window_view(padded, window)
    return np.asarray(np.partition(windows, half, axis=1)[:, half])
