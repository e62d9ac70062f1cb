"""Plane, point in contour and side points against plain geometry."""

from __future__ import annotations

from hypothesis import given, settings, strategies as st
import numpy as np
from perception_builders import pose
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import transform
from bpc_perception.core.measurement.paper.thickness import (
    containing_contour,
    cut_contours,
    fit_plane,
)
from bpc_perception.core.measurement.side_points import SidePoints
from bpc_perception.core.path.tangents import tangents

UP = np.array((0.0, 0.0, 1.0))
TILTED = pose((0.5, -0.1, 0.3), (30, -20, 50))


def flat_grid(count: int = 10, side: float = 0.04) -> Array:
    x, y = np.meshgrid(*2 * (np.linspace(-side / 2, side / 2, count),))
    return np.stack((x, y, np.zeros_like(x)), axis=-1).reshape(-1, 3)


def flat(polygon: list[tuple[float, float]]) -> Array:
    return np.column_stack((np.array(polygon, float), np.zeros(len(polygon))))


def sides_of(path: Array, contours: list[Array], normal: Array = UP) -> SidePoints:
    inside = np.zeros(len(path), np.intp)
    return cut_contours(path, tangents(path), contours, inside, normal)


BAND = flat([(0, -1), (10, -1), (10, 2), (0, 2)])  # 3 wide, 1 to the right of the x axis
LEFT = np.array((0.0, 2, 0))
ALONG = np.column_stack((np.linspace(1, 9, 9), np.zeros((9, 2))))


# The plane


@pytest.mark.parametrize('frame', [np.eye(4), TILTED, pose((0, 0, 0.02)), pose((1, 1, 1))],
                         ids=['origin', 'tilted', 'above', 'far'])
@pytest.mark.parametrize('side', [1.0, -1.0], ids=['from above', 'from below'])
def test_plane_goes_through_its_points_and_faces_the_viewer(frame: Array, side: float) -> None:
    points = transform(frame, flat_grid())
    viewer = transform(frame, np.array((0.01, 0.02, 0.5 * side)))
    plane = fit_plane(points, viewer)
    np.testing.assert_allclose(plane.height(points), 0, atol=1e-9)
    np.testing.assert_allclose(plane.normal, side * frame[:3, 2], atol=1e-7)
    assert np.linalg.norm(plane.normal) == pytest.approx(1)


def test_plane_averages_noise() -> None:
    points = transform(TILTED, flat_grid(40))
    points += np.random.default_rng(0).normal(0, 5e-5, points.shape)
    plane = fit_plane(points, TILTED[:3, 3] + TILTED[:3, 2])
    angle = np.degrees(np.arccos(plane.normal @ TILTED[:3, 2]))
    assert angle < 0.05


@pytest.mark.parametrize('points', [
    np.empty((0, 3)), np.zeros((2, 3)), np.tile((0.1, 0.2, 0.3), (5, 1)),
    np.linspace((0.1, 0.2, 0.3), (1, 2, 4), 20)],
    ids=['none', 'two', 'one place', 'a line'])
def test_points_that_span_no_plane_are_refused(points: Array) -> None:
    with pytest.raises(ValueError, match=r'^plane: expected .* found'):
        fit_plane(points, np.ones(3))


# Which contour holds a point


def even_odd(point: Array, polygon: Array) -> bool:
    """Plainly by the book, one edge after the other."""
    inside = False
    for (x1, y1), (x2, y2) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if (y1 > point[1]) != (y2 > point[1]) and \
                point[0] < x1 + (point[1] - y1) / (y2 - y1) * (x2 - x1):
            inside = not inside
    return inside


SQUARE = np.array(((0.0, 0), (4, 0), (4, 4), (0, 4)))
U_SHAPE = np.array(((0.0, 0), (6, 0), (6, 6), (4, 6), (4, 2), (2, 2), (2, 6), (0, 6)))


@pytest.mark.parametrize('polygon', [U_SHAPE, U_SHAPE[::-1], np.roll(U_SHAPE, 3, axis=0)],
                         ids=['counter-clockwise', 'clockwise', 'another first vertex'])
def test_a_concave_contour_holds_its_arms_and_not_the_bay(polygon: Array) -> None:
    points = np.array(((1.0, 5), (5, 5), (3, 5), (3, 1), (-1, 1), (7, 1), (3, 2.5)))
    assert containing_contour(points, [polygon]).tolist() == [0, 0, -1, 0, -1, -1, -1]


def test_a_ray_through_vertices_counts_them_once() -> None:
    diamond = np.array(((2.0, 0), (4, 2), (2, 4), (0, 2)))
    points = np.array(((2.0, 2), (-1, 2), (5, 2), (-1, 0), (-1, 4)))
    assert containing_contour(points, [diamond]).tolist() == [0, -1, -1, -1, -1]


def test_the_first_of_several_contours_counts() -> None:
    points = np.array(((1.0, 1), (11, 1), (20, 1)))
    contours = [SQUARE, SQUARE + np.array((10, 0)), SQUARE]
    assert containing_contour(points, contours).tolist() == [0, 1, -1]


def test_no_contours_hold_nothing() -> None:
    assert containing_contour(np.zeros((3, 2)), []).tolist() == [-1, -1, -1]


def test_no_points_are_held_by_nothing() -> None:
    assert len(containing_contour(np.empty((0, 2)), [SQUARE])) == 0


@settings(max_examples=60)
@given(st.integers(0, 10**6), st.integers(3, 40), st.booleans())
def test_containment_agrees_with_even_odd_counting(seed: int, vertices: int,
                                                  whole: bool) -> None:
    rng = np.random.default_rng(seed)
    polygon, points = rng.uniform(0, 8, (vertices, 2)), rng.uniform(-1, 9, (50, 2))
    if whole:  # as pixels are: many points level with vertices
        polygon, points = np.floor(polygon), np.floor(points) + np.array((0.5, 0))
    expected = [0 if even_odd(point, polygon) else -1 for point in points]
    assert containing_contour(points, [polygon]).tolist() == expected


# Side points


def test_side_points_of_a_straight_band_are_exact() -> None:
    sides = sides_of(ALONG, [BAND])
    np.testing.assert_allclose(sides.left, ALONG + LEFT)
    np.testing.assert_allclose(sides.right, ALONG - LEFT / 2)
    np.testing.assert_allclose(sides.left_distance, 2)
    np.testing.assert_allclose(sides.right_distance, 1)


def test_left_and_right_swap_with_the_direction_of_travel() -> None:
    sides = sides_of(ALONG[::-1], [BAND])
    np.testing.assert_allclose(sides.left_distance, 1)
    np.testing.assert_allclose(sides.right_distance, 2)


def test_left_and_right_swap_when_seen_from_below() -> None:
    np.testing.assert_allclose(sides_of(ALONG, [BAND], -UP).left_distance, 1)


def test_side_points_do_not_depend_on_the_frame() -> None:
    sides = sides_of(transform(TILTED, ALONG), [transform(TILTED, BAND)], TILTED[:3, 2])
    np.testing.assert_allclose(sides.left, transform(TILTED, ALONG + LEFT), atol=1e-12)
    np.testing.assert_allclose(sides.right_distance, 1)


@pytest.mark.parametrize('reverse', [False, True])
def test_the_nearest_of_several_intersections_counts(reverse: bool) -> None:
    # A hairpin: the strand at y = 0 and its other leg at y = 6 are in one contour.
    hairpin = flat([(0, -1), (12, -1), (12, 7), (0, 7), (0, 5), (10, 5), (10, 1), (0, 1)])
    sides = sides_of(ALONG, [hairpin[::-1] if reverse else hairpin])
    np.testing.assert_allclose(sides.left_distance, 1)
    np.testing.assert_allclose(sides.right_distance, 1)


def test_another_contour_does_not_count() -> None:
    near = flat([(0, 0.2), (10, 0.2), (10, 0.4), (0, 0.4)])
    sides = cut_contours(ALONG, tangents(ALONG), [near, BAND], np.ones(9, np.intp), UP)
    np.testing.assert_allclose(sides.left_distance, 2)


def test_points_in_no_contour_have_no_side_points() -> None:
    sides = cut_contours(ALONG, tangents(ALONG), [BAND], np.full(9, -1, np.intp), UP)
    assert np.isnan(sides.left).all()
    assert np.isnan(sides.right_distance).all()


def test_every_diameter_of_a_disc_is_its_width() -> None:
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    rim = 5 * np.column_stack((np.cos(angle), np.sin(angle), np.zeros(400)))
    for direction in np.radians((0, 17, 90, 211)):
        step = np.array((np.cos(direction), np.sin(direction), 0))
        path = np.outer((-0.1, 0, 0.1), step)
        sides = sides_of(path, [rim])
        width = np.linalg.norm(sides.left[1] - sides.right[1])
        # A chord's sagitta, 5 (1 - cos(pi / 400)), is what a polygon may lack on either side.
        assert width == pytest.approx(10, abs=4e-4)
        assert (sides.left[1] - path[1]) @ np.cross(UP, step) > 4.9


def test_a_vertex_on_the_cut_plane_gives_one_place() -> None:
    # Vertices at x = 5 on both sides, exactly where the plane cuts; also a whole edge on it.
    band = flat([(0, -1), (5, -1), (10, -1), (10, 2), (5, 2), (5, 3), (0, 3)])
    sides = sides_of(ALONG, [band])
    assert sides.right[4].tolist() == [5, -1, 0]
    assert sides.left[4].tolist() == [5, 2, 0]


def test_without_a_tangent_there_are_no_side_points() -> None:
    sides = cut_contours(ALONG, np.full_like(ALONG, np.nan), [BAND], np.zeros(9, np.intp), UP)
    assert np.isnan(sides.left).all()


def test_large_tables_are_cut_into_blocks_with_the_same_result() -> None:
    x = np.linspace(0, 10, 4000)
    rim = np.concatenate((np.column_stack((x, np.full(4000, -1.0))),
                          np.column_stack((x[::-1], np.full(4000, 2.0)))))
    path = np.column_stack((np.linspace(1, 9, 1000), np.zeros((1000, 2))))
    sides = sides_of(path, [np.column_stack((rim, np.zeros(len(rim))))])
    np.testing.assert_allclose(sides.left_distance, 2)
    np.testing.assert_allclose(sides.right_distance, 1)
