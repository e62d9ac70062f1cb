"""The section of a bead from the cloud: beads of known section, seen with noise."""

from __future__ import annotations

import numpy as np
from perception_builders import one_piece
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.measurement.cross_section.height import (
    fit_shapes,
    Roundness,
    shape,
    Shapes,
)

MM = 1e-3
COUNT, PIXEL, SPACING, NOISE = 300, 0.17 * MM, 0.1 * MM, 0.045 * MM
OFFSET = np.arange(-30, 31) * PIXEL
WIDTH, RISE = 1.3 * MM, 0.4 * MM
U = OFFSET / (WIDTH / 2)
SEMICIRCLE = np.sqrt(np.maximum(1 - U**2, 0))


def cloud(section: Array, depth: float = 0.0) -> Array:
    """Heights (N, M) of points across a bead of a section (M,), and of the bed beside it."""
    noise = np.random.default_rng(3).normal(0, NOISE, (COUNT, len(U)))
    return np.where(np.abs(U) < 1, RISE * section + depth, 0.0) + noise


def fitted(height: Array, foot_sigma: float = 0.01 * MM) -> Shapes:
    count = len(height)
    return fit_shapes(np.tile(U, (count, 1)), height, one_piece(count), SPACING,
                      np.full(count, foot_sigma))


@pytest.mark.parametrize('roundness', [0.0, 0.5, 1.0])
def test_height_and_shape_are_those_of_the_bead(roundness: float) -> None:
    found = fitted(cloud(shape(U, np.array(roundness))))
    crest, sigma = found.crest
    assert np.abs(crest - RISE).mean() < 0.012 * MM
    assert np.median(np.abs(found.roundness - roundness)) < 0.15
    off = np.abs(crest - RISE) / sigma
    assert 0.4 < (off < 1).mean() < 0.95
    assert (off < 3).all()


def test_half_a_circle_is_as_high_as_it_is_though_no_polynomial_is_one() -> None:
    crest, _ = fitted(cloud(SEMICIRCLE)).crest
    assert np.abs(crest - RISE).mean() < 0.03 * MM


def test_a_missing_flank_is_bridged() -> None:
    height = cloud(shape(U, np.array(0.0)))
    height[:, U > 0.3] = np.nan
    crest, _ = fitted(height).crest
    assert np.abs(crest - RISE).mean() < 0.015 * MM


def test_points_far_off_do_not_count() -> None:
    height = cloud(shape(U, np.array(0.0)))
    chosen = np.random.default_rng(5).random(height.shape)
    height[chosen < 0.1] += 8 * MM
    height[chosen > 0.95] -= 0.5 * MM
    crest, _ = fitted(height).crest
    assert np.abs(crest - RISE).max() < 0.06 * MM


@pytest.mark.parametrize('roundness', [0.0, 0.3])
def test_a_cloud_below_the_surface_tells_nothing(roundness: float) -> None:
    found = fitted(cloud(shape(U, np.array(roundness)), depth=-0.2 * MM))
    assert found.deep.all()
    assert np.isnan(found.rise).all()


def test_where_the_foot_is_hardly_known_the_flanks_tell_it() -> None:
    """A strand that hangs: its feet are lower than where the nozzle kept them."""
    found = fitted(cloud(shape(U, np.array(0.0)), depth=0.1 * MM), foot_sigma=0.1 * MM)
    assert np.abs(np.median(found.level) - 0.1 * MM) < 0.03 * MM
    crest, _ = found.crest
    assert np.abs(crest - RISE - 0.1 * MM).mean() < 0.015 * MM


def test_beads_that_hang_tell_their_shape_together() -> None:
    """One alone does not: how flat it is and how far it hangs look alike."""
    count, strands = COUNT, 8
    section, hangs = 0.4 * MM * shape(U, np.array(0.4)), 0.1 * MM

    def error(numbers: range) -> float:
        noise = [np.random.default_rng(number).normal(0, NOISE, (count, len(U)))
                 for number in numbers]
        height = np.concatenate(noise) + np.where(np.abs(U) < 1, section - hangs, -1 * MM)
        found = fit_shapes(np.tile(U, (len(height), 1)), height,
                           np.repeat(np.arange(len(numbers)), count), SPACING,
                           np.full(len(height), 0.2 * MM))
        return float(np.sqrt(np.mean((found.roundness[:count] - 0.4)**2)))

    alone = np.mean([error(range(number, number + 1)) for number in range(strands)])
    together = error(range(strands))
    assert together < 0.5 * alone


@pytest.mark.parametrize('roundness', [0.0, 0.4])
def test_how_round_others_are_tells_how_far_one_hangs(roundness: float) -> None:
    """The others are of the same ink, and lie on the bed."""
    place = np.linspace(-1, 1, 2001)
    area = RISE * WIDTH / 2 * np.trapezoid(shape(place, np.array(roundness)), place)
    like = Roundness.like(np.array([area]), np.array([RISE]), np.array([WIDTH]))
    assert like.usual == pytest.approx(roundness, abs=1e-3)
    hangs = 0.1 * MM
    height = cloud(shape(U, np.array(roundness)), depth=-hangs)
    found = fit_shapes(np.tile(U, (COUNT, 1)), height, one_piece(COUNT), SPACING,
                       np.full(COUNT, 0.5 * MM), round_like=like)
    assert np.abs(np.median(found.level) + hangs) < 0.02 * MM


def test_how_round_others_are_is_not_known_where_none_was_measured() -> None:
    nothing = np.full(3, np.nan)
    assert Roundness.like(nothing, nothing, nothing) == Roundness()


def test_nothing_is_told_without_points() -> None:
    height = np.full((COUNT, len(U)), np.nan)
    height[:50] = cloud(shape(U, np.array(0.0)))[:50]
    crest, sigma = fitted(height).crest
    assert np.isfinite(crest[:50]).all()
    assert np.isnan(crest[60:]).all()
    assert np.isnan(sigma[60:]).all()


def test_beads_of_different_pieces_are_not_mixed() -> None:
    height = cloud(shape(U, np.array(0.0)))
    height[COUNT // 2:] += RISE * np.maximum(1 - U**2, 0)
    piece = (np.arange(COUNT) >= COUNT // 2).astype(np.intp)
    crest, _ = fit_shapes(np.tile(U, (COUNT, 1)), height, piece, SPACING,
                          np.full(COUNT, 0.01 * MM)).crest
    assert np.abs(crest[:COUNT // 2] - RISE).mean() < 0.012 * MM
    assert np.abs(crest[COUNT // 2:] - 2 * RISE).mean() < 0.03 * MM
