"""A path is divided into strokes and travel, by the extruder or by the motion."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from perception_builders import path_through
import pytest

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.strokes import corners, stroke_numbers

MM = 1e-3
SPACING = 0.2 * MM


def along(*corners_mm: tuple[float, float, float]) -> Array:
    """Points (N, 3), 0.2 mm apart, on straight lines through corners [mm]."""
    parts = []
    for start, end in pairwise(corners_mm):
        count = round(float(np.linalg.norm(np.subtract(end, start))) / 0.2)
        parts.append(np.linspace(start, end, count, endpoint=False))
    return np.concatenate((*parts, np.array(corners_mm[-1:]))) * MM


def numbers(path: DepositionPath, low: Flags | None = None) -> Index:
    height = path.points[:, 2]
    return stroke_numbers(path, height, np.ones(len(path), bool) if low is None else low)


def runs(found: Index) -> list[tuple[int, int]]:
    """The stroke numbers in their order, each with how many points it has in a row."""
    begins = np.flatnonzero(np.diff(found, prepend=-1))
    return [(int(found[begin]), int(count)) for begin, count in zip(
        begins, np.diff(np.append(begins, len(found))), strict=True)]


def test_strokes_are_runs_in_which_ink_is_pushed_out() -> None:
    points = along((0, 0, 0), (20, 0, 0))
    on = (points[:, 0] < 8 * MM) | (points[:, 0] > 12.1 * MM)
    assert runs(numbers(path_through(points, extruding=on))) == [(1, 40), (0, 21), (2, 40)]


@pytest.mark.parametrize(('outage', 'expected'), [(7.0, [(1, 51), (2, 51)]), (0.8, [(1, 102)])])
def test_a_stroke_ends_where_the_path_was_not_heard_for_a_while(
        outage: float, expected: list[tuple[int, int]]) -> None:
    path = path_through(np.concatenate((along((0, 0, 0), (10, 0, 0)),
                                        along((10, 20, 0), (0, 20, 0)))))
    later = path.time + np.where(np.arange(102) > 50, outage - 2.0, 0.0)  # 2 s for the 20 mm
    assert runs(numbers(replace(path, time=later))) == expected


def test_a_nozzle_that_waits_with_ink_flowing_goes_on_with_its_stroke() -> None:
    path = path_through(along((0, 0, 0), (20, 0, 0)))
    later = path.time + np.where(np.arange(101) > 50, 7.0, 0.0)
    assert runs(numbers(replace(path, time=later))) == [(1, 101)]


@pytest.mark.parametrize('off', [1, 3])
def test_the_extruder_may_stutter(off: int) -> None:
    points = along((0, 0, 0), (20, 0, 0))
    on = np.ones(len(points), bool)
    on[50:50 + off] = False
    assert set(numbers(path_through(points, extruding=on))) == {1}


def test_a_moment_of_ink_is_no_stroke() -> None:
    points = along((0, 0, 0), (20, 0, 0))
    on = points[:, 0] > 10 * MM
    on[10:12] = True
    assert set(numbers(path_through(points, extruding=on))[:45]) == {0}


def test_where_the_nozzle_is_off_the_bed_nothing_is_laid() -> None:
    points = along((0, 0, 0), (20, 0, 0))
    low = points[:, 0] < 10.1 * MM
    assert runs(numbers(path_through(points), low)) == [(1, 51), (0, 50)]


def at_speed(points: Array, speed: Array) -> DepositionPath:
    """A path with a speed (N,) on the way to each point [m/s]."""
    path = path_through(points)
    step = np.append(0.0, np.diff(path.arc_length))
    return replace(path, time=np.cumsum(step / speed))


def test_a_state_that_is_late_does_not_make_a_stroke_of_fast_travel() -> None:
    points = along((0, 0, 0), (20, 0, 0), (20, 10, 0), (40, 10, 0))
    travel = (points[:, 0] > 19.9 * MM) & (points[:, 1] > 0.1 * MM) & (points[:, 1] < 9.9 * MM)
    path = at_speed(points, np.where(travel, 0.05, 0.01))
    begin, end = path.time[np.flatnonzero(travel)[[0, -1]]]
    on = (path.time < begin + 0.015) | (path.time > end - 0.01)
    found = numbers(replace(path, extruding=on))
    assert (found[travel] == 0).all()
    assert (found[~travel] > 0).mean() > 0.98


def test_a_state_that_is_late_does_not_make_a_stroke_of_what_lies_behind_a_corner() -> None:
    points = along((0, 0, 0), (20, 0, 0), (20, 10, 0), (0, 10, 0))
    travel = (points[:, 1] > 0.1 * MM) & (points[:, 1] < 9.9 * MM)
    path = path_through(points)
    begin, end = path.time[np.flatnonzero(travel)[[0, -1]]]
    on = (path.time < begin + 0.06) | (path.time > end - 0.06)
    found = numbers(replace(path, extruding=on))
    assert (found[travel] == 0).all()


def test_a_corner_within_a_stroke_is_no_end() -> None:
    points = along((0, 0, 0), (20, 0, 0), (20, 20, 0))
    assert set(numbers(path_through(points))) == {1}
    turned = corners(points)
    assert np.argmax(turned) == 100
    assert turned.max() == pytest.approx(np.pi / 2)
    assert np.count_nonzero(turned) < 10


def unknown(points: Array, speed: Array | float = 0.01) -> DepositionPath:
    path = at_speed(points, np.broadcast_to(speed, len(points)))
    never = np.zeros(len(path), bool)
    return replace(path, extruding=never, extruder_known=never)


@pytest.mark.parametrize('hop', [0.3, 2.0])
@pytest.mark.parametrize('tilt', [0.0, 0.03])
def test_without_an_extruder_a_hop_is_travel(hop: float, tilt: float) -> None:
    points = along((0, 0, 0), (20, 0, 0), (20, 0, hop), (0, 5, hop), (0, 5, 0), (20, 5, 0))
    lifted = points[:, 2] > 0.5 * hop * MM
    points[:, 2] += tilt * points[:, 1]
    found = numbers(unknown(points))
    assert (found[lifted] == 0).all()
    assert set(found) == {0, 1, 2}
    low = np.flatnonzero(points[:, 2] - tilt * points[:, 1] < 1e-9)
    assert (found[low] > 0).mean() > 0.98


def test_without_an_extruder_a_higher_layer_is_a_stroke() -> None:
    points = along((0, 0, 0), (20, 0, 0), (20, 0, 0.3), (0, 0, 0.3), (0, 0, 0.6), (20, 0, 0.6))
    found = numbers(unknown(points))
    for height in (0.0, 0.3, 0.6):
        layer = np.abs(points[:, 2] - height * MM) < 1e-9
        assert (found[layer] > 0).mean() > 0.97, height


def test_without_an_extruder_a_curved_bed_is_no_hop() -> None:
    x = np.arange(0, 60, 0.2)
    points = np.column_stack((x, 0 * x, 50 - np.sqrt(50**2 - (x - 30)**2))) * MM
    assert set(numbers(unknown(points))) == {1}


def test_without_an_extruder_a_fast_way_is_travel() -> None:
    points = along((0, 0, 0), (20, 0, 0), (20, 10, 0), (0, 10, 0))
    travel = (points[:, 1] > 0.1 * MM) & (points[:, 1] < 9.9 * MM)
    found = numbers(unknown(points, np.where(travel, 0.05, 0.01)))
    assert (found[travel][2:-2] == 0).all()
    assert set(found) == {0, 1, 2}


def test_the_last_lift_is_travel_unless_it_is_a_layer() -> None:
    for lift, strokes in ((3.0, {0, 1}), (0.3, {1})):
        points = along((0, 0, 0), (20, 0, 0), (20, 0, lift), (0, 0, lift))
        assert set(numbers(unknown(points))) == strokes


@pytest.mark.parametrize('count', [0, 1, 2, 3])
def test_a_path_of_few_points(count: int) -> None:
    points = along((0, 0, 0), (20, 0, 0))[:count]
    for path in (path_through(points, extruding=[True] * count), unknown(points)):
        assert len(numbers(path)) == count
