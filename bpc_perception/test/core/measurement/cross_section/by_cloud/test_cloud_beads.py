"""Beads in a cloud: superellipses of known width and place, seen with noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from perception_builders import sections_of
import pytest

from bpc_perception.core.measurement.cross_section.by_cloud.cloud_beads import (
    CloudBeads,
    find_cloud_beads,
    Lines,
)
from bpc_perception.core.measurement.cross_section.by_cloud.rough_beads import half_way_down
from bpc_perception.core.measurement.cross_section.sections.sections import Sections

Array = NDArray[np.float64]
MM = 1e-3
COUNT, PIXEL, SPACING = 600, 0.17 * MM, 0.17 * MM
OFFSET = np.arange(-24, 25) * PIXEL / 2
ALONG = np.arange(COUNT) * SPACING
# As a path crosses rows of pixels, the points lie elsewhere each time.
SHIFT = PIXEL * ((0.061 * np.arange(COUNT)) % 1.0 - 0.5)
WIDTH = 1.5 * MM * (1 + 0.08 * np.sin(2 * np.pi * ALONG / (20 * MM)))
NOISE_M = 0.045 * MM


def bead(middle: Array | float = 0.0, ratio: float = 0.35, exponent: float = 1.8,
         depth: float = 0.0, lean: float = 0.0, width: Array = WIDTH) -> Sections:
    """A bead on a bed; rays lean to the left, and light goes into it."""
    rng = np.random.default_rng(3)
    fine = np.linspace(-3 * MM, 3 * MM, 1200)
    u = np.abs(fine - np.reshape(middle, (-1, 1))) / (width / 2)[:, None]
    z = ratio * width[:, None] * np.maximum(1 - u**exponent, 0.0)**(1 / exponent)
    z = z - depth * (u < 1)
    # A ray that meets the bed at an offset meets the surface where place + height * lean is that.
    height = np.empty((COUNT, len(OFFSET)))
    for row, at in enumerate(np.maximum.accumulate(fine + z * lean, axis=1)):
        height[row] = np.interp(OFFSET + SHIFT[row], at, z[row])
    noisy = height + rng.normal(0, NOISE_M, height.shape)
    sections = sections_of(noisy, OFFSET, PIXEL, SPACING)
    place = OFFSET + SHIFT[:, None] - noisy * lean
    return replace(sections, place=place.astype(np.float32))


def beads_in(sections: Sections, lean: float = 0.0, pictured: Lines | None = None) -> CloudBeads:
    found, model = find_cloud_beads(sections, np.full(COUNT, lean), pictured)
    assert model is not None
    return replace(found, sigma=np.hypot(found.sigma, model.sigma * found.width))


def compare(found: CloudBeads) -> None:
    off = found.width - WIDTH
    assert np.abs(off).mean() < 0.04 * MM
    assert np.mean(np.abs(off) < 2 * found.sigma) > 0.85


@pytest.mark.parametrize(('ratio', 'exponent'), [(0.35, 1.6), (0.5, 2.0), (0.25, 2.2)])
@pytest.mark.parametrize('lean', [0.0, -0.3])
def test_widths_are_those_of_beads_whatever_their_colour(ratio: float, exponent: float,
                                                         lean: float) -> None:
    compare(beads_in(bead(ratio=ratio, exponent=exponent, lean=lean), lean))


@pytest.mark.parametrize('ratio', [0.35, 0.5])
def test_a_neck_is_as_narrow_as_it_is(ratio: float) -> None:
    """It is told as the mean of the millimetre on either side, from which points are taken."""
    off = ALONG - ALONG.mean()
    dip = np.where(np.abs(off) < 3 * MM, np.cos(np.pi * off / (6 * MM))**2, 0.0)
    width = WIDTH * (1 - 0.4 * dip)
    found = beads_in(bead(ratio=ratio, width=width), pictured=Lines(np.zeros(COUNT), width / 2))
    in_neck = found.width[np.abs(off) < 0.2 * MM].mean()
    assert in_neck == pytest.approx(width[np.abs(off) < 1 * MM].mean(), abs=0.12 * MM)


def test_beads_are_found_beside_their_path() -> None:
    middle = 0.2 * MM * np.sin(2 * np.pi * ALONG / (40 * MM))
    found = beads_in(bead(middle))
    compare(found)
    np.testing.assert_allclose((found.left - found.right) / 2, middle, atol=0.06 * MM)


@pytest.mark.parametrize('depth', [0.2, 0.25, 0.3])
def test_light_that_goes_into_the_ink_makes_it_no_narrower(depth: float) -> None:
    """Its points step down below the bed at the feet."""
    compare(beads_in(bead(ratio=0.4, depth=depth * MM)))


@pytest.mark.parametrize('off', [-0.06, 0.06])
def test_edges_in_a_picture_that_are_off_mislead_nobody(off: float) -> None:
    lines = Lines(np.zeros(COUNT), WIDTH / 2 + off * MM)
    compare(beads_in(bead(), pictured=lines))


def test_of_a_bed_that_is_bare_nothing_is_told() -> None:
    rng = np.random.default_rng(1)
    bare = sections_of(rng.normal(0, NOISE_M, (COUNT, len(OFFSET))), OFFSET, PIXEL, SPACING)
    found, model = find_cloud_beads(bare, np.zeros(COUNT))
    assert model is None
    assert np.isnan(found.width).all()


def test_where_points_are_missing_nothing_is_told_or_it_is_not_sure() -> None:
    sections = bead()
    height = sections.height.copy()
    height[200:260] = np.nan
    found = beads_in(replace(sections, height=height))
    assert np.isnan(found.width[210:250]).all()
    assert np.abs(found.width - WIDTH)[:190].mean() < 0.04 * MM


def test_a_model_that_is_known_tells_a_part_of_the_print() -> None:
    whole = bead()
    _, model = find_cloud_beads(whole, np.zeros(COUNT))
    part = np.arange(100, 160)
    found, _ = find_cloud_beads(whole.of(part, 1), np.zeros(len(part)), model=model)
    assert np.abs(found.width - WIDTH[part]).mean() < 0.05 * MM


def test_a_bead_comes_half_way_down_between_two_points() -> None:
    height = np.tile(np.maximum(1 - np.abs(OFFSET) / MM, 0.0) * MM, (20, 1))
    left, right = half_way_down(sections_of(height, OFFSET, PIXEL, SPACING))
    ridge = np.median(height[0, np.abs(OFFSET) <= 2 * PIXEL])
    np.testing.assert_allclose(left, MM - ridge / 2, rtol=1e-4)
    np.testing.assert_allclose(right, -(MM - ridge / 2), rtol=1e-4)
