"""Projection, and the cloud between pixels."""

from __future__ import annotations

import numpy as np
from perception_builders import bed, camera, capture_of
import pytest

from bpc_perception.core.capture.capture import Capture, PinholeCamera, sample_cloud

K = np.array(((800.0, 0, 320), (0, 780.0, 240), (0, 0, 1)))
NAN = np.nan


def test_pinhole_projection() -> None:
    view = PinholeCamera(K, np.zeros(5), 640, 480)
    np.testing.assert_allclose(view.pixels(np.array(((0.1, -0.2, 2.0), (0, 0, 1)))),
                               ((360, 162), (320, 240)))
    assert view.focal_length == 790


@pytest.mark.parametrize('points', [(0, 0, -1), (0.1, 0.1, 0), (NAN, 0, 1), (0, 0, np.inf)])
def test_what_is_not_in_front_has_no_pixel(points: tuple[float, float, float]) -> None:
    view = PinholeCamera(K, np.zeros(5), 640, 480)
    seen = view.pixels(np.array((points, (0.1, -0.2, 2.0))))
    assert np.isnan(seen[0]).all()
    np.testing.assert_allclose(seen[1], (360, 162))


def test_no_points_have_no_pixels() -> None:
    assert PinholeCamera(K, np.zeros(5), 640, 480).pixels(np.empty((0, 3))).shape == (0, 2)


def test_distortion_follows_the_plumb_bob_formula() -> None:
    k1, k2, p1, p2, k3 = coefficients = (-0.2, 0.07, 0.003, -0.002, 0.01)
    x, y = 0.3, -0.2
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    u = 800 * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + 320
    v = 780 * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + 240
    view = PinholeCamera(K, np.array(coefficients), 640, 480)
    np.testing.assert_allclose(view.pixels(2 * np.array(((x, y, 1.0),))), ((u, v),), atol=1e-9)


def test_no_coefficients_mean_no_distortion() -> None:
    view = PinholeCamera(K, np.zeros(0), 640, 480)
    np.testing.assert_allclose(view.pixels(np.array(((0.1, -0.2, 2.0),))), ((360, 162),))


@pytest.mark.parametrize(('uv', 'inside'), [
    ((0, 0), True), ((639, 479), True), ((320.5, 12.3), True), ((-0.01, 5), False),
    ((639.01, 5), False), ((5, 479.01), False), ((5, -0.01), False), ((NAN, 5), False)])
def test_image_reaches_to_the_outermost_pixel_centres(uv: tuple[float, float],
                                                      inside: bool) -> None:
    assert PinholeCamera(K, np.zeros(5), 640, 480).contains(np.array((uv,))).tolist() == [inside]


def test_image_and_cloud_must_have_the_size_of_the_camera_info() -> None:
    capture = capture_of(bed())
    with pytest.raises(ValueError, match=r'expected shape \(120, 161, 3\).*found \(120, 160, 3\)'):
        Capture(0, '', capture.image, capture.cloud, camera(width=161))


def ramp(height: int = 4, width: int = 5) -> np.ndarray:
    """A cloud whose points are u, 10 v and u v."""
    v, u = np.mgrid[0:height, 0:width].astype(np.float32)
    return np.stack((u, 10 * v, u * v), axis=-1)


@pytest.mark.parametrize('uv', [(0, 0), (4, 3), (4, 0), (0, 3), (2, 1)])
def test_cloud_is_exact_at_pixels(uv: tuple[int, int]) -> None:
    u, v = uv
    np.testing.assert_array_equal(sample_cloud(ramp(), np.array((uv,), float)),
                                  ((u, 10 * v, u * v),))


@pytest.mark.parametrize('uv', [(0.5, 0.25), (3.75, 2.5), (4, 1.5), (1.5, 3)])
def test_cloud_is_bilinear_between_pixels(uv: tuple[float, float]) -> None:
    u, v = uv  # bilinear functions are met exactly
    np.testing.assert_allclose(sample_cloud(ramp(), np.array((uv,))), ((u, 10 * v, u * v),))


@pytest.mark.parametrize(('uv', 'known'), [
    ((2, 2), False), ((1.5, 2), False), ((2.5, 1.5), False), ((1, 1), True), ((1, 2), True),
    ((2, 1), True), ((3, 2), True), ((2, 3), True), ((1, 1.5), True), ((3, 2.5), True)])
def test_a_missing_point_counts_only_where_it_carries_weight(uv: tuple[float, float],
                                                            known: bool) -> None:
    cloud = ramp()
    cloud[2, 2] = NAN
    sampled = sample_cloud(cloud, np.array((uv,), float))
    expected = (uv[0], 10 * uv[1], uv[0] * uv[1]) if known else (NAN, NAN, NAN)
    np.testing.assert_allclose(sampled, (expected,))


@pytest.mark.parametrize('uv', [(-0.001, 1), (4.001, 1), (1, -0.001), (1, 3.001), (1e9, 1),
                                (NAN, 1), (1, np.inf)])
def test_there_is_nothing_outside_the_cloud(uv: tuple[float, float]) -> None:
    assert np.isnan(sample_cloud(ramp(), np.array((uv,)))).all()


def test_a_cloud_of_one_pixel_has_a_point() -> None:
    np.testing.assert_array_equal(sample_cloud(ramp(1, 1), np.zeros((1, 2))), ((0, 0, 0),))
