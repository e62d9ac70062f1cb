"""Feet in a cloud: points of sections that are known in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
import pytest

from bpc_perception.core.measurement.cross_section.by_cloud.folded_section import (
    fit_feet,
    section_height,
)

Array = NDArray[np.float64]
NOISE = 0.06  # of a point, in half widths


def seen(shift: float, top: float, exponent: float, lean: float = 0.0, depth: float = 0.0,
         count: int = 6000, seed: int = 1) -> tuple[Array, Array]:
    """Places and heights (K,) of points, in half widths of the picture.

    The feet of a superellipse |u|^n + (z / top)^n = 1 lie ``shift`` outward of the picture's
    edges. Light goes ``depth`` deep into the ink.
    """
    rng = np.random.default_rng(seed)
    true = np.linspace(-1.9, 1.9, count)
    z = top * np.maximum(1 - np.abs(true)**exponent, 0.0)**(1 / exponent)
    place = (true + z * lean) * (1 + shift)
    visible = place >= np.maximum.accumulate(place)
    height = (z - depth * (np.abs(true) < 1)) * (1 + shift) + rng.normal(0.0, NOISE, count)
    return place[visible], height[visible]


def feet_in(u: Array, height: Array, lean: float) -> tuple[Array, Array]:
    """Shifts and sigmas (2,) of the feet."""
    found = fit_feet(u, height, lean)
    return found.shift, found.sigma


@pytest.mark.parametrize('shift', [-0.06, 0.0, 0.08])
@pytest.mark.parametrize(('top', 'exponent'), [(0.7, 1.6), (1.0, 2.0), (0.44, 2.2)])
def test_feet_are_found_beside_the_edges_of_the_picture(
        shift: float, top: float, exponent: float) -> None:
    feet, sigma = feet_in(*seen(shift, top, exponent), 0.0)
    assert feet == pytest.approx(shift, abs=0.03)
    assert (np.abs(feet - shift) < 2.5 * sigma).all()
    assert (sigma < 0.04).all()


def test_feet_are_found_behind_the_ridge_that_hides_them() -> None:
    """Seen at 45 degrees the far foot of a round bead is hidden."""
    found = [fit_feet(*seen(0.0, 1.0, 2.0, lean=1.0, seed=seed), 1.0) for seed in range(10)]
    shift, sigma = (np.array([getattr(one, name) for one in found]) for name in ('shift', 'sigma'))
    assert (np.abs(shift) < 2.5 * sigma).mean() > 0.85
    assert abs(shift[:, 1].mean()) < 0.05


@pytest.mark.parametrize('shift', [-0.05, 0.0, 0.05])
@pytest.mark.parametrize('depth', [0.2, 0.26, 0.35])
def test_feet_are_found_though_light_goes_into_the_ink_or_nothing_is_told(
        shift: float, depth: float) -> None:
    """Ink begins where the cloud steps down into it."""
    feet, sigma = feet_in(*seen(shift, 0.7, 1.6, depth=depth), 0.0)
    assert not (np.abs(feet - shift) > 3 * sigma).any()
    assert np.isfinite(feet).all() or depth < 0.25


def test_a_section_known_from_another_side_tells_more_of_few_points() -> None:
    u, height = seen(0.08, 0.7, 1.6)
    known = fit_feet(u, height, 0.0).section
    few = slice(None, None, 12)
    alone, like = (fit_feet(u[few], height[few], 0.0, section) for section in (None, known))
    assert (like.sigma < alone.sigma).all()
    assert (np.abs(like.shift - 0.08) < 2.5 * like.sigma).all()


def test_of_a_film_of_ink_the_cloud_tells_no_feet() -> None:
    feet, _ = feet_in(*seen(0.0, 0.1, 2.0), 0.0)
    assert np.isnan(feet).all()


def test_where_the_cloud_shows_no_bead_on_a_bed_it_tells_no_feet() -> None:
    """A step beside the bead, as of a dish's rim."""
    u, height = seen(0.0, 0.7, 1.6)
    feet, _ = feet_in(u, height + np.where(u > 0.5, 0.6, 0.0), 0.0)
    assert np.isnan(feet).all()


def test_a_few_points_tell_no_feet() -> None:
    u, height = seen(0.0, 0.7, 1.6)
    feet, _ = feet_in(u[::50], height[::50], 0.0)
    assert np.isnan(feet).all()


def test_a_section_is_as_high_as_it_is_said() -> None:
    """A parabola of height 0.6 with feet at 1.1 and 0.9."""
    fitted = np.array((1.1, 0.9, 0.6, 2.0, 1.0, 0.0))
    u = np.array((-1.0, -0.9, 0.1, 0.6, 1.1, 1.2))
    true = [0, 0, 0.6, 0.6 * 0.75, 0, 0]
    assert section_height(u, 0.0, fitted) == pytest.approx(np.array(true), abs=2e-3)
