"""What camera and cloud show along lines."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
import pytest

from bpc_perception.core.measurement.cross_section.sections.lines import points_at

Make = Callable[[], NDArray[np.float32]]

HEIGHT, WIDTH = 5, 7
NOWHERE = (-0.6, 6.6, 1e9, -1e9, np.nan)


def cloud() -> NDArray[np.float32]:
    """A cloud (5, 7, 3) whose points tell their pixels."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    return np.stack((u, v, 10 * v + u), axis=2).astype(np.float32)


def with_colours() -> NDArray[np.float32]:
    """The cloud as a view into points of 16 bytes, as most drivers send them."""
    whole = np.full((HEIGHT, WIDTH, 4), np.pi, np.float32)
    whole[..., :3] = cloud()
    return whole[..., :3]


def with_padded_rows() -> NDArray[np.float32]:
    whole = np.full((HEIGHT, WIDTH + 2, 3), np.pi, np.float32)
    whole[:, :WIDTH] = cloud()
    return whole[:, :WIDTH]


def by_axis() -> NDArray[np.float32]:
    return np.asfortranarray(cloud())


@pytest.mark.parametrize('make', [cloud, with_colours, with_padded_rows, by_axis])
def test_points_are_those_of_the_nearest_pixels(make: Make) -> None:
    u, v = np.meshgrid(np.array((-0.4, 0.0, 0.4, 2.6, 6.4, *NOWHERE)), np.array((-0.4, 3.7, 4.4)))
    found = points_at(make(), np.stack((u, v)).astype(np.float32))
    expected = np.full((3, 10, 3), np.nan)
    for row, pixel_v in enumerate((0, 4, 4)):
        for column, pixel_u in enumerate((0, 0, 0, 3, 6)):
            expected[row, column] = pixel_u, pixel_v, 10 * pixel_v + pixel_u
    np.testing.assert_array_equal(found, expected)
    assert found.dtype == np.float32


@pytest.mark.parametrize('make', [with_colours, by_axis])
def test_above_and_below_the_image_there_is_no_point(make: Make) -> None:
    v = np.array((NOWHERE,), np.float32)
    assert np.isnan(points_at(make(), np.stack((np.full_like(v, 2.0), v)))).all()
