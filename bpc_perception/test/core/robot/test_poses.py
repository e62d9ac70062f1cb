"""Poses at a stamp: between two neighbours, or not at all."""

from __future__ import annotations

import numpy as np
from perception_builders import pose
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.robot.poses import pose_matrix, PoseBuffer

MS = 10**6


def test_a_quaternion_turns_as_the_textbook_says() -> None:
    half = np.sqrt(0.5)  # a quarter turn around z takes x to y
    T = pose_matrix(np.array((1.0, 2, 3)), np.array((0, 0, half, half)))
    np.testing.assert_allclose(T @ (1, 0, 0, 1), (1, 3, 3, 1), atol=1e-15)


def test_a_quaternion_of_almost_unit_length_is_normalized() -> None:
    T = pose_matrix(np.zeros(3), 1.005 * np.array((0.5, 0.5, 0.5, 0.5)))
    np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(('position', 'quaternion'), [
    ((0, 0, 0), (0, 0, 0, 0)), ((0, 0, 0), (0, 0, 0, 2)), ((0, 0, 0), (0, 0, 0, 0.9)),
    ((np.nan, 0, 0), (0, 0, 0, 1)), ((0, np.inf, 0), (0, 0, 0, 1)),
    ((0, 0, 0), (np.nan, 0, 0, 1))])
def test_what_is_no_pose_is_refused(position: tuple[float, ...],
                                    quaternion: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match=r'^pose: expected .*, found '):
        pose_matrix(np.array(position, float), np.array(quaternion, float))


@pytest.fixture
def buffer() -> PoseBuffer:
    """Poses at 0, 100 and 300 ms."""
    made = PoseBuffer(maximum_speed=np.inf, maximum_turn=np.inf)
    made.add(0, pose((0, 0, 0), (0, 0, 0)))
    made.add(100 * MS, pose((1, 0, 0), (60, 0, 0)))
    made.add(300 * MS, pose((1, 2, 0), (0, 0, 90)))
    return made


@pytest.mark.parametrize(('time', 'expected'), [
    (0, pose()), (100, pose((1, 0, 0), (60, 0, 0))), (25, pose((0.25, 0, 0), (15, 0, 0))),
    (50, pose((0.5, 0, 0), (30, 0, 0)))])
def test_position_is_linear_and_rotation_uniform(buffer: PoseBuffer, time: int,
                                                 expected: Array) -> None:
    found = buffer.at(time * MS, 0.1)
    assert found is not None
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_rotation_takes_the_shortest_way_about_one_axis(buffer: PoseBuffer) -> None:
    middle = buffer.at(200 * MS, 0.2)
    assert middle is not None
    first, last = pose(angles=(60, 0, 0)), pose(angles=(0, 0, 90))
    there = first[:3, :3].T @ middle[:3, :3]
    np.testing.assert_allclose(there @ there, first[:3, :3].T @ last[:3, :3], atol=1e-12)
    np.testing.assert_allclose(middle[:3, 3], (1, 1, 0))


@pytest.mark.parametrize(('time', 'gap', 'known'), [
    (-1, 9, False), (301, 9, False), (200, 0.19, False), (200, 0.2, True), (300, 0.001, True),
    (0, 0.001, True)])
def test_there_is_no_pose_but_between_near_ones(buffer: PoseBuffer, time: int, gap: float,
                                                known: bool) -> None:
    assert (buffer.at(time * MS, gap) is not None) == known


def test_an_empty_buffer_has_no_pose() -> None:
    empty = PoseBuffer()
    assert empty.at(0, 9) is None


@pytest.mark.parametrize('stamp', [300 * MS, 299 * MS, 0])
def test_late_and_repeated_poses_are_refused(buffer: PoseBuffer, stamp: int) -> None:
    assert not buffer.add(stamp, np.zeros((4, 4)))
    assert buffer.at(301 * MS, 1) is None
    kept = buffer.at(300 * MS, 1)
    assert kept is not None
    np.testing.assert_allclose(kept, pose((1, 2, 0), (0, 0, 90)))


@pytest.mark.parametrize('glitch', [pose((0.4, 0, 0)), pose(angles=(0, 40, 0))])
def test_a_pose_that_cannot_have_been_reached_is_refused(glitch: Array) -> None:
    buffer = PoseBuffer()
    for time in range(0, 100, 10):
        assert buffer.add(time * MS, pose((1e-4 * time, 0, 0)))
    assert not buffer.add(100 * MS, glitch)
    assert buffer.add(110 * MS, pose((0.011, 0, 0)))
    found = buffer.at(100 * MS, 0.1)
    assert found is not None
    np.testing.assert_allclose(found, pose((0.01, 0, 0)), atol=1e-12)
    # What lasts is believed.
    assert [buffer.add(time * MS, glitch) for time in (120, 300)] == [False, True]


def test_after_a_clock_was_set_back_nothing_is_known_of_before() -> None:
    buffer = PoseBuffer()
    for time in range(0, 7000, 100):
        buffer.add(time * MS, pose((1e-4 * time, 0, 0)))
    assert buffer.add(2000 * MS, pose((0.7, 0, 0)))  # taken after the last of these
    assert buffer.at(2050 * MS, 0.1) is None
    assert buffer.add(2100 * MS, pose((0.71, 0, 0)))
    found = buffer.at(2050 * MS, 0.1)
    assert found is not None
    np.testing.assert_allclose(found[:3, 3], (0.705, 0, 0), atol=1e-12)


def test_a_cleared_buffer_takes_earlier_stamps(buffer: PoseBuffer) -> None:
    buffer.clear()
    assert buffer.at(50 * MS, 9) is None
    assert buffer.add(0, pose())


def test_only_the_latest_poses_are_kept() -> None:
    short = PoseBuffer(length=2, maximum_speed=np.inf)
    for time in range(3):
        short.add(time * MS, pose((time, 0, 0)))
    assert short.at(0, 9) is None
    assert short.at(1 * MS, 9) is not None


def test_stamps_of_today_are_told_apart_to_the_nanosecond() -> None:
    now = 1_700_000_000 * 10**9
    precise = PoseBuffer(maximum_speed=np.inf)
    precise.add(now, pose((0, 0, 0)))
    precise.add(now + 1, pose((1, 0, 0)))
    found = precise.at(now + 1, 1)
    assert found is not None
    assert found[0, 3] == 1
