"""Directions of a path against plain geometry."""

from __future__ import annotations

import numpy as np
from perception_builders import one_piece
import pytest

from bpc_perception.core.path.tangents import smoothed_tangents, tangents


def test_tangents_are_central_differences_and_one_sided_at_the_ends() -> None:
    corner = np.array(((0.0, 0, 0), (2, 0, 0), (2, 2, 0)))
    half = np.sqrt(0.5)
    np.testing.assert_allclose(tangents(corner), ((1, 0, 0), (half, half, 0), (0, 1, 0)))


def test_tangents_of_a_circle_are_exact() -> None:
    angle = np.linspace(0, 6, 100)
    circle = np.column_stack((np.cos(angle), np.sin(angle), np.zeros(100)))
    expected = np.column_stack((-np.sin(angle), np.cos(angle), np.zeros(100)))
    np.testing.assert_allclose(tangents(circle)[1:-1], expected[1:-1], atol=1e-12)


def test_there_is_no_tangent_where_points_coincide() -> None:
    path = np.array(((0.0, 0, 0), (0, 0, 0), (0, 0, 0), (1, 0, 0)))
    assert np.isnan(tangents(path)).all(axis=1).tolist() == [True, True, False, False]


@pytest.mark.parametrize('count', [0, 1])
def test_a_single_point_has_no_tangent(count: int) -> None:
    found = tangents(np.zeros((count, 3)))
    assert found.shape == (count, 3)
    assert np.isnan(found).all()


@pytest.mark.parametrize('hole', [0.01, 0.4, 1.0, 3.0])
def test_next_to_a_hole_the_direction_is_that_of_the_curve(hole: float) -> None:
    angle = np.arange(0, 6, 0.04)  # each 0.2 mm on a circle of 5 mm
    # Pieces of many, one, many, two and many points.
    pieces = np.split(angle, (50, 51, 90, 92))
    angle = np.concatenate([piece + number * hole for number, piece in enumerate(pieces)])
    circle = 5e-3 * np.column_stack((np.cos(angle), np.sin(angle), np.zeros(len(angle))))
    found = smoothed_tangents(circle, one_piece(len(angle)), np.arange(len(angle)), 1e-3)
    expected = np.column_stack((-np.sin(angle), np.cos(angle), np.zeros(len(angle))))
    known = np.ones(len(angle), bool)
    known[50] = hole < 0.2  # one point alone has no direction of its own
    # A piece of two points has the direction of the chord between them.
    np.testing.assert_allclose(found[known], expected[known], atol=0.021)
