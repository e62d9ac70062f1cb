"""Picture and cloud weighed on where feet are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.special import ndtr

from bpc_perception.core.measurement.cross_section.edges.feet import Feet, unlike_step, weigh

Array = NDArray[np.float64]
ROWS, EDGE = 30, 10.0  # samples


def faded(light: Array | float, blur: float = 1.5) -> Array:
    """Shares (ROWS, 31) of a bead with an edge at ``EDGE``, so bright from the middle to it."""
    fine = np.arange(0, 31, 0.05)
    level = np.where(fine < EDGE, np.interp(fine, np.linspace(0, EDGE, np.size(light)),
                                            np.atleast_1d(light)), 0.0)
    place = np.arange(31)
    weight = np.exp(-(((place[:, None] - fine) / blur)**2) / 2) * 0.05 / blur / np.sqrt(2 * np.pi)
    # Beyond the middle it goes on as there.
    share = weight @ level + level[0] * (1 - ndtr(place / blur))
    return np.tile(share, (ROWS, 1))


def unlike(share: Array) -> float:
    return unlike_step(share, np.full(ROWS, EDGE), np.full(ROWS, EDGE))[0]


@pytest.mark.parametrize(('blur', 'most'), [(1.3, 0.01), (2.0, 0.02), (3.0, 0.03)])
def test_a_blurred_step_is_about_like_one_however_blurred(blur: float, most: float) -> None:
    """A wide blur reaches to where the level of the ink is read."""
    assert unlike(faded(1.0, blur)) < most


@pytest.mark.parametrize('blur', [1.5, 2.0, 3.0])
def test_the_blur_of_a_step_is_told(blur: float) -> None:
    _, found = unlike_step(faded(1.0, blur), np.full(ROWS, EDGE), np.full(ROWS, EDGE))
    assert found == pytest.approx(blur, rel=0.05)


def test_ink_that_fades_toward_its_rim_is_unlike_a_step() -> None:
    assert unlike(faded(np.array((1.0, 1.0, 0.95, 0.6)))) > 0.05


def test_who_knows_better_counts_more() -> None:
    shift, of_cloud, sigma = weigh(0.2, 0.3, 0.1, 5.0)
    assert shift == pytest.approx(0.3 * 0.04 / 0.05)
    assert of_cloud == pytest.approx(shift - 0.3)
    assert sigma == pytest.approx(0.2 * 0.1 / np.hypot(0.2, 0.1))


def test_where_the_cloud_tells_nothing_the_picture_is_as_sure_as_before() -> None:
    np.testing.assert_array_equal(weigh(0.1, np.nan, np.nan, 5.0), (0.0, np.nan, 0.1))


def test_what_contradicts_the_picture_is_not_averaged_with_it() -> None:
    np.testing.assert_array_equal(weigh(0.05, -0.6, 0.08, 5.0), (0.0, np.nan, 0.6))
    np.testing.assert_array_equal(weigh(0.5, 0.6, 0.08, 2.0), (0.0, np.nan, 0.6))


def test_a_side_is_far_or_near_as_the_camera_stands() -> None:
    known = np.arange(11.0)
    feet = Feet(np.stack((known, -known)), np.stack((-known, known)), np.tile(known / 10, (2, 1)))
    shift, of_cloud, sigma = feet.outward(np.array((0.0, 0.41, -0.41)))
    assert shift.tolist() == [0.0, 2.0, -2.0]
    assert of_cloud.tolist() == [0.0, -2.0, 2.0]
    assert sigma == pytest.approx((0.0, 0.2, 0.2))


def test_where_nothing_is_seen_beside_an_edge_it_is_as_unsure_as_can_be() -> None:
    share = faded(1.0)
    share[:, 11:] = np.nan  # glare on the bed
    assert unlike(share) == unlike(np.full_like(share, np.nan)) > 0.05
