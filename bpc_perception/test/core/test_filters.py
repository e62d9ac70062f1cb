"""Medians of arrays with unknown values, and in pieces."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_perception.core.filters import masked_median, running_median, window_sums

PIECES = {'one piece': (40,), 'long ones': (15, 25), 'short ones': (3, 1, 36), 'few values': (2,)}


@pytest.mark.parametrize('lengths', PIECES.values(), ids=PIECES.keys())
@pytest.mark.parametrize('window', [1, 5, 21])
def test_a_running_median_is_that_of_the_neighbours_in_a_piece(lengths: tuple[int, ...],
                                                               window: int) -> None:
    rng = np.random.default_rng(0)
    values = [rng.normal(size=(length, 2)) for length in lengths]
    expected = []
    for part in values:
        half = window // 2 if len(part) >= window else len(part) // 2
        count = window if len(part) >= window else len(part)
        padded = np.pad(part, ((half, half), (0, 0)), 'edge')
        expected += [np.sort(padded[row:row + count], axis=0)[count // 2]
                     for row in range(len(part))]
    found = running_median(np.concatenate(values), window,
                           np.repeat(np.arange(len(lengths)), lengths))
    assert np.array_equal(found, expected)


def test_unknown_values_are_bridged_before_a_running_median_is_taken() -> None:
    values = np.array((np.nan, 1.0, np.nan, 3.0, np.nan))
    found = running_median(np.stack((values, np.full(5, np.nan)), axis=1), 1, np.zeros(5, int))
    assert np.array_equal(found[:, 0], (1, 1, 2, 3, 3))
    assert np.isnan(found[:, 1]).all()


def test_a_masked_median_is_that_of_what_counts() -> None:
    values = np.array(((5, 1, 3, 9), (5, 1, 3, 9), (5, 1, 3, 9)), np.float32)
    mask = np.array(((1, 1, 1, 0), (1, 0, 0, 1), (0, 0, 0, 0)), bool)
    assert np.array_equal(masked_median(values, mask), (3, 7, np.nan), equal_nan=True)
    colours = np.stack((values, -values, 2 * values), axis=2)
    assert np.array_equal(masked_median(colours, mask)[:2], ((3, -3, 6), (7, -7, 14)))


def test_sums_are_those_from_the_first_row_of_each_window_to_its_end() -> None:
    values = np.array(((1, 10), (2, 20), (4, 40)))
    found = window_sums(values, (np.array((0, 0, 1)), np.array((1, 3, 3))))
    assert np.array_equal(found, ((1, 10), (7, 70), (6, 60)))
