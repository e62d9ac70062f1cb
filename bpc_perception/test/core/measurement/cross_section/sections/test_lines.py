"""What camera and cloud show along lines."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from perception_builders import pose
import pytest

from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.geometry import transform
from bpc_perception.core.measurement.cross_section.sections.lines import (
    distances_along,
    Lines,
    pixels_along,
    points_at,
)
from bpc_perception.core.measurement.view import View

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


def across_a_tilted_bed() -> tuple[View, Lines]:
    """Three lines of 21 samples, 0.3 m before a camera that is tilted."""
    camera = PinholeCamera(np.array(((900.0, 0, 320), (0, 900, 240), (0, 0, 1))), np.zeros(5), 640,
                           480)
    capture = Capture(0, '', np.zeros((480, 640, 3), np.uint8),
                      np.full((480, 640, 3), np.nan, np.float32), camera)
    lateral = np.array(((1.0, 0, 0), (0, 1, 0), (0.6, 0.8, 0)))
    foot = np.array(((0.0, 0, 0.3), (0.01, 0.02, 0.3), (-0.03, 0, 0.31)))
    return (View(capture, pose((0.01, 0, 0), (20, 10, -15))),
            Lines(foot, lateral, np.linspace(-0.002, 0.002, 21)))


def test_pixels_along_lines_are_those_of_their_samples() -> None:
    view, lines = across_a_tilted_bed()
    samples = lines.foot[:, None] + lines.offset[:, None] * lines.lateral[:, None]
    expected = view.pixels(samples.reshape(-1, 3)).reshape(3, 21, 2)
    np.testing.assert_allclose(np.moveaxis(pixels_along(view, lines), 0, -1), expected, atol=2e-3)


def test_samples_are_as_far_along_their_lines_as_their_offsets() -> None:
    view, lines = across_a_tilted_bed()
    samples = lines.foot[:, None] + lines.offset[:, None] * lines.lateral[:, None]
    points = transform(view.T_camera_base, samples).astype(np.float32)
    np.testing.assert_allclose(distances_along(view, points, lines),
                               np.tile(lines.offset, (3, 1)), atol=1e-7)
