"""Where blurred edges are steepest, on profiles across beads that are known in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from perception_builders import one_piece
import pytest
from scipy.special import ndtr

from bpc_perception.core.measurement.cross_section.edges.rim import steepest_shift

Array = NDArray[np.float64]
ROWS = 40
PIECE = one_piece(ROWS)
ANYWHERE = np.zeros(ROWS)  # the path passes all places between two rows of pixels alike
SIGMA = 1.6  # of the blur [samples]
OUTSIDE = 30.0  # so far out the profile is known [samples]


def bead(edge: float, inside: Array, phase: Array, sigma: float = SIGMA) -> Array:
    """Shares (ROWS, 40) of a bead, symmetric about sample 0, with its edge at ``edge`` samples.

    ``inside`` (K,) are levels at equal distances from the middle to the edge. The blur is that of
    narrow strips of each level, in closed form.
    """
    borders = np.linspace(0, edge, len(inside) + 1)
    place = np.arange(40)[None, :] + phase[:, None]
    share = np.zeros(place.shape)
    for level, near, far in zip(inside, borders[:-1], borders[1:], strict=True):
        for low, high in ((near, far), (-far, -near)):
            share += level * (ndtr((place - low) / sigma) - ndtr((place - high) / sigma))
    return share


def crossing(share: Array, level: float) -> Array:
    """Where (ROWS,) shares fall through a level, first [samples]."""
    first = np.argmax(share < level, axis=1)
    row = np.arange(len(share))
    above, below = share[row, first - 1], share[row, first]
    return first - (level - below) / (above - below)


def error(edge: float, inside: Array, level: float, sigma: float = SIGMA) -> float:
    """How far off [samples] the edge is found, started from where shares fall through a level."""
    phase = np.linspace(-0.5, 0.5, ROWS)
    share = bead(edge, inside, phase, sigma)
    start = crossing(share, level)
    shift = steepest_shift(share, start, np.full(ROWS, 0.01), ANYWHERE, ROWS, 1.0, PIECE)
    # Started from a crossing, each row knows its own place.
    return float(np.mean(start + phase + shift - edge))


@pytest.mark.parametrize('level', [0.4, 0.5, 0.6])
@pytest.mark.parametrize('edge', [5.1, 12.3, 20.0])
def test_an_even_bead_has_its_edge_whatever_level_it_is_looked_for_at(
        edge: float, level: float) -> None:
    assert abs(error(edge, np.ones(20), level)) < 0.06


@pytest.mark.parametrize(('inside', 'level'), [
    (np.where(np.arange(20) < 3, 0.7, 1.15), 0.5),  # the ridge shines, the rim is darker
    (np.linspace(0.85, 1.15, 20), 0.5),  # shaded towards the rim
    (np.linspace(1.1, 0.9, 20), 0.5)])  # and lit there
def test_a_narrow_bead_that_is_not_even(inside: Array, level: float) -> None:
    assert abs(error(5.1, inside, level)) < 0.2  # a tenth of a pixel


def test_what_a_half_level_makes_of_a_narrow_bead_that_shines() -> None:
    edge, inside = 5.1, np.where(np.arange(20) < 3, 0.7, 1.25)
    phase = np.linspace(-0.5, 0.5, ROWS)
    half = float(np.mean(crossing(bead(edge, inside, phase), 0.5) + phase - edge))
    assert half > 0.3
    assert abs(error(edge, inside, 0.5)) < half / 2


@pytest.mark.parametrize('sigma', [1.0, 2.0, 4.0])
def test_blur_does_not_move_the_edge_of_a_wide_bead(sigma: float) -> None:
    assert abs(error(20.0, np.ones(20), 0.5, sigma)) < 0.06


def test_where_a_reflection_takes_the_rim_there_is_no_edge() -> None:
    inside = np.where(np.arange(20) < 12, 1.0, 0.45)
    phase = np.linspace(-0.5, 0.5, ROWS)
    share = bead(16.0, inside, phase)
    start = np.full(ROWS, 13.0) - phase  # half-way between ink and bed, in the reflection
    shift = steepest_shift(share, start, np.full(ROWS, 0.01), ANYWHERE, ROWS, 1.0, PIECE)
    assert np.isnan(shift).all()


def test_what_is_not_seen_has_no_steepest_place() -> None:
    share = bead(10.0, np.ones(20), np.zeros(ROWS))
    hidden = share.copy()
    hidden[:, 10] = np.nan
    noise = np.full(ROWS, 0.01)
    nowhere, anywhere = np.full(ROWS, np.nan), np.full(ROWS, 10.0)
    for seen, start in ((hidden, anywhere), (share, nowhere), (np.zeros_like(share), anywhere)):
        assert np.isnan(
            steepest_shift(seen, start, noise, ANYWHERE, ROWS, 1.0, PIECE)).all()


def test_in_noise_the_half_level_counts_for_more() -> None:
    share = bead(12.0, np.ones(20), np.zeros(ROWS))
    start = np.full(ROWS, 11.5)
    quiet, noisy = (steepest_shift(share, start, np.full(ROWS, noise), ANYWHERE, ROWS, 0.1, PIECE)
                    for noise in (0.01, 2.0))
    np.testing.assert_allclose(quiet, 0.5, atol=0.06)
    assert (np.abs(noisy) < 0.25).all()
