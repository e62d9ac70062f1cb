"""A bead's section from the cloud: beads of known width and height, seen with noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from perception_builders import sections_of
import pytest

from bpc_perception.core.measurement.cross_section.by_cloud.rough_beads import rough_beads
from bpc_perception.core.measurement.cross_section.on_ink.bead import fit_beads
from bpc_perception.core.measurement.cross_section.on_ink.below import Beneath
from bpc_perception.core.measurement.cross_section.on_ink.cliffs import breaks_off
from bpc_perception.core.measurement.cross_section.on_ink.known import (
    best_of,
    carried_along,
    mean_of,
)
from bpc_perception.core.measurement.cross_section.sections.sections import Sections

MM = 1e-3
COUNT, PIXEL, SPACING = 1200, 0.17 * MM, 0.2 * MM
OFFSET = np.arange(-30, 31) * PIXEL / 2
WIDTH, TOP, LAYER = 2.0 * MM, 0.6 * MM, 0.5 * MM


def bead(width: float = WIDTH, middle: float = 0.0, noise: float = 0.045 * MM,
         missing: float = 0.0) -> Sections:
    """A bead on another one: beyond its rim the surface lies a layer lower."""
    rng = np.random.default_rng(1)
    height = np.tile(TOP * (1 - (2 * (OFFSET - middle) / width)**2), (COUNT, 1))
    height = np.where(height > 0, height, -LAYER) + rng.normal(0, noise, (COUNT, len(OFFSET)))
    height[rng.random(height.shape) < missing] = np.nan
    return sections_of(height, OFFSET, PIXEL, SPACING)


@pytest.mark.parametrize('missing', [0.0, 0.3])
@pytest.mark.parametrize(('width', 'middle'), [(2.0, 0.0), (2.0, 0.3), (1.3, -0.2), (3.0, 0.0)])
def test_width_height_and_middle_are_those_of_the_bead(width: float, middle: float,
                                                       missing: float) -> None:
    found = fit_beads(sections := bead(width * MM, middle * MM, missing=missing),
                      *rough_beads(sections))
    assert np.isfinite(found.width).all()
    for values, true, sigma in ((found.width, width * MM, found.width_sigma),
                                (found.top, TOP, found.top_sigma)):
        off = (values - true) / sigma
        assert np.abs(values.mean() - true) < 0.02 * true
        assert np.mean(np.abs(off) < 2) > 0.85
    np.testing.assert_allclose(found.middle, middle * MM, atol=0.08 * MM)


@pytest.mark.parametrize('thought', [0.85, 1.1, 1.2])
def test_a_bead_that_is_thought_too_narrow_or_wide_is_told_as_it_is(thought: float) -> None:
    """What lies beside it is not of it."""
    found = fit_beads(bead(), np.zeros(COUNT), np.full(COUNT, thought * WIDTH))
    assert abs(np.median(found.width) - WIDTH) < 0.02 * WIDTH
    assert abs(np.median(found.top) - TOP) < 0.02 * TOP


def test_where_the_cloud_has_too_few_points_nothing_is_told() -> None:
    sections = bead()
    bare = sections.height.copy()
    bare[40:80] = np.nan
    found = fit_beads(replace(sections, height=bare), np.zeros(COUNT), np.full(COUNT, WIDTH))
    assert np.isnan(found.width[45:75]).all()
    assert np.isfinite(found.width[:35]).all()


def test_a_bead_breaks_off_where_it_ends() -> None:
    beneath = Beneath(np.full(COUNT, LAYER), np.full(COUNT, LAYER))
    none = np.zeros((COUNT, len(OFFSET)), bool)
    left, right = breaks_off(bead(middle=0.1 * MM), none, beneath)
    np.testing.assert_allclose(left, 1.1 * MM, atol=PIXEL / 2)
    np.testing.assert_allclose(right, 0.9 * MM, atol=PIXEL / 2)
    crossed = none.copy()
    crossed[60] = True
    left, right = breaks_off(bead(), crossed, beneath)
    assert np.isnan(left[60])
    assert np.isnan(right[60])


def test_what_is_known_better_weighs_more() -> None:
    one, other = (np.array((1.0, np.nan, np.nan)), np.array((0.1, 0.1, 0.1))), (
        np.array((2.0, 2.0, np.nan)), np.array((0.2, 0.2, 0.2)))
    values, sigmas = mean_of(one, other)
    np.testing.assert_allclose(values, (1.2, 2.0, np.nan))
    np.testing.assert_allclose(sigmas[:2], (0.1 / 1.25**0.5, 0.2))
    values, sigmas = best_of(one, other)
    np.testing.assert_allclose(values, (1.0, 2.0, np.nan))


def test_a_width_is_carried_along_and_gets_less_sure() -> None:
    width = np.full(COUNT, WIDTH)
    width[50:70] = np.nan
    values, sigmas = carried_along(width, np.full(COUNT, 0.02 * MM), bead())
    np.testing.assert_allclose(values, WIDTH)
    assert sigmas[59] > 1.5 * sigmas[49]
    values, _ = carried_along(np.full(COUNT, np.nan), np.full(COUNT, np.nan), bead())
    assert np.isnan(values).all()
