"""Rigid transforms and planes."""

from __future__ import annotations

import numpy as np
from perception_builders import pose
import pytest

from bpc_perception.core.geometry import invert, Plane, transform

QUARTER = pose((1, 2, 3), (90, 0, 0))  # a quarter turn around z, then a shift


def test_transform_turns_then_shifts() -> None:
    np.testing.assert_allclose(transform(QUARTER, np.array((1.0, 0, 0))), (1, 3, 3), atol=1e-15)


def test_transform_takes_any_shape_of_points() -> None:
    points = np.arange(24.0).reshape(2, 4, 3)
    moved = transform(QUARTER, points)
    assert moved.shape == (2, 4, 3)
    np.testing.assert_allclose(moved[1, 2], transform(QUARTER, points[1, 2]))


def test_invert_undoes_a_transform() -> None:
    T = pose((0.3, -0.2, 0.7), (20, -35, 110))
    np.testing.assert_allclose(invert(T) @ T, np.eye(4), atol=1e-15)
    np.testing.assert_allclose(invert(T), np.linalg.inv(T), atol=1e-14)


def test_plane_height_is_signed() -> None:
    plane = Plane(np.array((0.0, 0.0, 1.0)), -2.0)  # z = 2
    np.testing.assert_array_equal(plane.height(np.array(((5.0, 5, 3), (0, 0, -1)))), (1, -3))


def test_plane_projection_is_the_foot_of_the_perpendicular() -> None:
    plane = Plane(np.array((3.0, 0.0, 4.0)) / 5, -1.0)
    np.testing.assert_allclose(plane.project(np.array(((5.0, 7, 0),))), ((3.8, 7, -1.6),))
    np.testing.assert_allclose(plane.height(plane.project(np.array((9.0, 9, 9)))), 0, atol=1e-15)


@pytest.mark.parametrize('normal', [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1), (1, 1, 1),
                                    (-3, 2, 0.1)])
def test_plane_coordinates_keep_distances_and_orientation(
        normal: tuple[float, float, float]) -> None:
    n = np.array(normal, float) / np.linalg.norm(normal)
    plane = Plane(n, 0.4)
    a, b, c = plane.project(np.array(((0.0, 0, 0), (1, 2, -1), (0.5, -1, 3))))
    flat = plane.coordinates(np.stack((a, b, c)))
    assert np.linalg.norm(flat[1] - flat[0]) == pytest.approx(np.linalg.norm(b - a))
    area = np.linalg.det(np.stack((flat[1] - flat[0], flat[2] - flat[0])))
    # Counter-clockwise as seen from the normal's tip.
    assert area == pytest.approx(np.cross(b - a, c - a) @ n)
