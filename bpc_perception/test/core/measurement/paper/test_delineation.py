"""Delineation step by step: raw, rough, assigned, fused."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from perception_builders import band_image, bed, HEIGHT, INK, WIDTH
import pytest

from bpc_perception.core.config import SegmentationConfig
from bpc_perception.core.measurement.paper.delineation import (
    corresponding,
    delineate,
    fuse,
    rough_contours,
)

CONFIG = SegmentationConfig()
Image = NDArray[np.uint8]


def line_of(count: int, v: int = 0, first: int = 0) -> NDArray[np.int32]:
    """Vertices (first, v), (first + 1, v), ... of an open trace."""
    return np.stack((first + np.arange(count), np.full(count, v)), axis=1).astype(np.int32)


def distance_to_edge(contour: Image, mask: Image) -> NDArray[np.float64]:
    """How far [pixels] each vertex is from the border between ink and bed pixels."""
    grown = cv2.resize(mask, None, fx=8, fy=8, interpolation=cv2.INTER_NEAREST)
    ink = cv2.distanceTransform(grown, cv2.DIST_L2, 5) / 8
    out = cv2.distanceTransform(1 - grown, cv2.DIST_L2, 5) / 8
    u, v = (8 * contour + 4).T
    return np.maximum(ink[v, u], out[v, u]).astype(np.float64)


def filled(contour: NDArray[np.int32], shape: tuple[int, int] = (HEIGHT, WIDTH)) -> int:
    mask = np.zeros(shape, np.uint8)
    cv2.drawContours(mask, [contour], 0, 1, cv2.FILLED)
    return int(mask.sum())


def disc(centre: tuple[int, int] = (80, 60), radius: int = 30) -> Image:
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    image = bed()
    image[np.hypot(u - centre[0], v - centre[1]) <= radius] = INK
    return image


def ink_mask(image: Image) -> Image:
    return (image == np.array(INK)).all(axis=2).astype(np.uint8)


@pytest.mark.parametrize('image', [band_image(), disc()], ids=['rectangle', 'disc'])
def test_a_region_gives_one_contour_within_a_pixel_of_its_edge(image: Image) -> None:
    fused = delineate(image, CONFIG).fused
    assert len(fused) == 1
    mask = ink_mask(image)
    assert distance_to_edge(fused[0], mask).max() <= 1.1
    # It goes all the way round: what it encloses is the region, give or take its border.
    border = 4 * np.sqrt(mask.sum()) * 2
    assert abs(filled(fused[0]) - int(mask.sum())) <= border
    edge = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0][0][:, 0]
    gap = np.linalg.norm(edge[:, None].astype(float) - fused[0], axis=2).min(axis=1)
    assert gap.max() <= 2


def test_broken_outline_needs_the_dilation_to_enclose_its_region() -> None:
    half = [np.stack((np.cos(a), np.sin(a)), axis=1) * 30 + (80, 60)
            for a in (np.linspace(0.05, 3.1, 200), np.linspace(3.2, 6.23, 200))]
    # Suzuki's contour of an open arc: there and back again.
    raw = [np.rint(np.concatenate((arc, arc[::-1]))).astype(np.int32) for arc in half]
    closed = rough_contours(raw, (HEIGHT, WIDTH), SegmentationConfig(kernel_size=7))
    assert len(closed) == 1
    assert filled(closed[0]) > 2500
    torn = rough_contours(raw, (HEIGHT, WIDTH), SegmentationConfig(kernel_size=1))
    assert all(filled(contour) < 1500 for contour in torn)


def test_two_regions_give_two_contours() -> None:
    image = band_image((20, 30))
    image[80:95, 40:110] = INK
    fused = delineate(image, CONFIG).fused
    middles = sorted(float(contour[:, 1].mean()) for contour in fused)
    assert middles == pytest.approx([25, 87], abs=1)


def test_an_empty_image_gives_nothing() -> None:
    found = delineate(bed(), CONFIG)
    assert (found.raw, found.rough, found.fused) == ([], [], [])


@pytest.mark.parametrize('columns', [(0, 100), (60, WIDTH - 1)])
def test_a_region_at_the_border_of_the_image_stays_closed(columns: tuple[int, int]) -> None:
    image = band_image((50, 60), columns)
    fused = delineate(image, CONFIG).fused
    assert len(fused) == 1
    u, v = fused[0].T
    assert np.min(u) <= max(columns[0], 2)
    assert np.max(u) >= min(columns[1], WIDTH - 3)
    assert (np.min(v), np.max(v)) in {(49, 60), (50, 60), (50, 61), (49, 61)}
    assert min(u) >= 0
    assert max(u) < WIDTH


def test_rough_contours_lie_outside_by_half_the_kernel() -> None:
    raw = [np.array(((40, 40), (80, 40), (80, 80), (40, 80)), np.int32)]
    contour, = rough_contours(raw, (HEIGHT, WIDTH), SegmentationConfig(kernel_size=9))
    # Dilated by 4 pixels; the edge pixel found may be either beside the border.
    for low, high in zip(contour.min(axis=0), contour.max(axis=0), strict=True):
        assert low in (35, 36)
        assert high in (84, 85)


SQUARES = [np.array(((10, 10), (50, 10), (50, 50), (10, 50)), np.int32),
           np.array(((80, 10), (120, 10), (120, 50), (80, 50)), np.int32)]


@pytest.mark.parametrize(('inside', 'of', 'assigned'), [
    (0, 5, False), (2, 5, False), (3, 5, True), (5, 5, True), (2, 4, False), (3, 4, True)])
def test_a_raw_contour_belongs_where_more_than_half_of_it_is(inside: int, of: int,
                                                            assigned: bool) -> None:
    raw = np.array([(20 + i, 30) for i in range(inside)]
                   + [(60 + i, 30) for i in range(of - inside)], np.int32)
    found = corresponding([raw], SQUARES, (HEIGHT, WIDTH))
    assert [len(group) for group in found] == [int(assigned), 0]


def test_each_raw_contour_goes_to_its_own_region() -> None:
    left, right = line_of(10, 30, 20), line_of(10, 30, 90)
    found = corresponding([right, left], SQUARES, (HEIGHT, WIDTH))
    np.testing.assert_array_equal(found[0], [left])
    np.testing.assert_array_equal(found[1], [right])


def test_without_raw_contours_nothing_is_assigned() -> None:
    assert corresponding([], SQUARES, (HEIGHT, WIDTH)) == [[], []]


def test_vertices_between_anchors_are_inserted_forwards() -> None:
    fused = fuse(np.array(((0, 1), (5, 1), (10, 1)), np.int32), [line_of(30)], 10)
    # From the last anchor back to the first it is ten vertices, a jump.
    np.testing.assert_array_equal(fused, line_of(11))


def test_vertices_between_anchors_are_inserted_backwards() -> None:
    fused = fuse(np.array(((10, 1), (5, 1), (0, 1)), np.int32), [line_of(30)], 10)
    np.testing.assert_array_equal(fused, line_of(11)[::-1])


@pytest.mark.parametrize(('step', 'stitched'), [(9, True), (10, False), (25, False)])
def test_a_step_of_the_jump_threshold_is_a_jump(step: int, stitched: bool) -> None:
    fused = fuse(np.array(((0, 1), (step, 1)), np.int32), [line_of(30)], 10)
    between = {tuple(vertex) for vertex in fused.tolist()} - {(0, 0), (step, 0)}
    assert between == ({(u, 0) for u in range(1, step)} if stitched else set())


def test_anchors_on_two_raw_contours_are_joined_directly() -> None:
    # Neighbours in memory: the last vertex of the first and the first of the second.
    first, second = line_of(5), line_of(5, first=6)
    fused = fuse(np.array(((3, 1), (7, 1)), np.int32), [first, second], 10)
    np.testing.assert_array_equal(fused, ((3, 0), (7, 0)))


def test_the_nearest_raw_vertex_is_the_anchor() -> None:
    raw = np.array(((0, 0), (10, 0), (4, 3)), np.int32)
    np.testing.assert_array_equal(
        fuse(np.array(((4, 5), (9, 1)), np.int32), [raw], 1), ((4, 3), (10, 0)))


def test_no_vertex_comes_twice_in_a_row() -> None:
    rough = np.array(((0, 1), (0, 2), (1, 2), (5, 2), (5, 1), (5, 1)), np.int32)
    fused = fuse(rough, [line_of(30)], 10)
    assert (np.abs(fused - np.roll(fused, 1, axis=0)).sum(axis=1) > 0).all()


def test_many_small_specks_do_not_open_the_region_they_lie_on() -> None:
    image = band_image((40, 80))
    for u in range(40, 120, 8):  # reflections in the ink, with edges of their own
        image[58:62, u:u + 3] = 255
    fused = delineate(image, CONFIG).fused
    assert len(fused) == 1
    assert filled(fused[0]) >= 41 * 101 * 0.97
