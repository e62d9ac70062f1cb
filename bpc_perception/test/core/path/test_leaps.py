"""A step that the nozzle did not make is told from one that it did."""

from __future__ import annotations

import numpy as np
from perception_builders import at_ns, SPEED, states_until
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import PathConfig
from bpc_perception.core.path.leaps import LeapFinder, Step, Whereabouts
from bpc_perception.core.path.tracker import PrintTracker

MM = 1e-3
PERIOD_S = 0.01


def steps(times: Array, x: Array) -> list[Step]:
    """What is certain of a nozzle that is at x (N,) [m] at times (N,) [s]."""
    finder = LeapFinder()
    tips = np.column_stack((x, np.zeros((len(x), 2))))
    return [step for time, tip in zip(times, tips, strict=True)
            for step in finder.add(at_ns(time), tip)]


def leaps(times: Array, x: Array) -> list[float]:
    """Where (L,) they lead [m]."""
    return [float(step.tip[0]) for step in steps(times, x) if step.leap]


@pytest.mark.parametrize('speed', [0.002, 0.01, 0.1, 0.3])
@pytest.mark.parametrize('period', [0.004, 0.01, 0.1])
def test_a_nozzle_that_starts_at_once_goes_on_and_stops_makes_no_leap(speed: float,
                                                                      period: float) -> None:
    rng = np.random.default_rng(1)
    times = np.arange(0, 4, period)
    x = speed * np.clip(times - 1, 0, 2)
    late = times + rng.uniform(0, min(0.5 * period, 0.02), len(times))
    noisy = x + rng.normal(0, 0.02 * MM, len(x))
    found = steps(late, noisy)
    assert not any(step.leap for step in found)
    np.testing.assert_array_equal([step.tip[0] for step in found], noisy[:len(found)])
    assert len(found) >= len(times) - 1


@pytest.mark.parametrize('speed', [0.005, 0.01, 0.03])
@pytest.mark.parametrize('frozen', [0.15, 0.3, 0.7, 2.0])
def test_poses_that_are_repeated_until_they_recover_leave_a_leap(speed: float,
                                                                 frozen: float) -> None:
    times = np.arange(0, 5, PERIOD_S)
    x = speed * times
    stuck = (times > 1) & (times < 1 + frozen)
    found = leaps(times, np.where(stuck, speed, x))
    assert found == [pytest.approx(speed * (1 + frozen), abs=1.1 * speed * PERIOD_S)]


@pytest.mark.parametrize('back', [0.3, 1.0, 2.0])
def test_a_clock_that_is_set_back_leaves_a_leap(back: float) -> None:
    times = np.arange(0, 6, PERIOD_S)
    stamped = times - np.where(times > 2, back, 0)
    later = stamped > np.maximum.accumulate(np.append(-1, stamped[:-1]))  # others are refused
    assert leaps(stamped[later], SPEED * times[later]) == [
        pytest.approx(SPEED * (2 + back), abs=2.1 * SPEED * PERIOD_S)]


@pytest.mark.parametrize('speed', [0.002, 0.01, 0.1, 0.3])
@pytest.mark.parametrize('times_each', [2, 5])
def test_poses_that_are_all_given_several_times_make_no_leap(speed: float,
                                                             times_each: int) -> None:
    times = np.arange(0, 4, PERIOD_S)
    x = speed * np.clip(times - 1, 0, 2)
    again = x[np.arange(len(x)) // times_each * times_each]
    found = steps(times, again)
    assert not any(step.leap for step in found)
    np.testing.assert_array_equal([step.tip[0] for step in found], again[:len(found)])
    assert len(found) > len(times) - times_each
    stuck = (times > 2) & (times < 2.7)
    assert leaps(times, np.where(stuck, again[200], again)) == [
        pytest.approx(speed * 1.7, abs=1.1 * speed * times_each * PERIOD_S)]


@pytest.mark.parametrize('off', [-15 * MM, 2 * MM, 15 * MM])
@pytest.mark.parametrize('speed', [0.0, 0.01])
def test_a_single_pose_that_is_wrong_is_no_place_where_the_nozzle_was(speed: float,
                                                                      off: float) -> None:
    times = np.arange(0, 3, PERIOD_S)
    x = speed * times
    wrong = x.copy()
    wrong[100] += off
    found = steps(times, wrong)
    assert [step.stamp_ns for step in found if step.wrong] == [at_ns(times[100])]
    assert not any(step.leap for step in found)


@pytest.mark.parametrize('back', [0.05, 0.2])
@pytest.mark.parametrize('speed', [0.003, 0.01])
def test_a_clock_that_is_set_back_a_little_is_known_by_its_late_poses(speed: float,
                                                                      back: float) -> None:
    tracker = PrintTracker(PathConfig())
    for time in np.arange(0, 4, PERIOD_S):
        tracker.add_pose(at_ns(time - back * (time > 2)), np.array((speed * time, 0.0, 0.0)))
    assert tracker.leaps == 1


def test_of_two_poses_of_one_stamp_the_first_counts() -> None:
    """As of a publisher beside the robot that sends zeros for joints which it does not know."""
    tracker = PrintTracker(PathConfig())
    for number, time in enumerate(np.arange(0, 4, PERIOD_S)):
        tracker.add_pose(at_ns(time), np.array((SPEED * time, 0.0, 0.0)))
        if number % 2:
            assert not tracker.add_pose(at_ns(time), np.array((0.4, 0.3, 0.0)))
    assert tracker.leaps == 0


def test_poses_that_come_in_another_order_are_late_and_no_more() -> None:
    tracker, rng = PrintTracker(PathConfig()), np.random.default_rng(0)
    times = np.arange(0, 4, PERIOD_S)
    for time in times[np.argsort(times + rng.uniform(0, 0.05, len(times)))]:
        tracker.add_pose(at_ns(time), np.array((SPEED * time, 0.0, 0.0)))
    assert tracker.leaps == 0


def test_where_many_poses_are_wrong_none_is_believed() -> None:
    """As of a source that mixes old poses with new ones, some of which fit by chance."""
    tracker, rng = PrintTracker(PathConfig()), np.random.default_rng(0)
    for sample in states_until(6.0, 0.02):
        tracker.add_extruder(sample)
    for time in np.arange(0, 6, PERIOD_S):
        old = rng.uniform(0, 1) if 2 < time < 4 and rng.random() < 0.2 else 0.0
        tracker.add_pose(at_ns(time), np.array((SPEED * (time - old), 0.0, 0.0)))
    path = tracker.path()
    assert path is not None
    assert not ((path.time > 2.8) & (path.time < 5)).any()
    again = path.time > 5
    np.testing.assert_allclose(path.points[again, 0], SPEED * path.time[again], atol=0.1 * MM)
    assert again.sum() > 10


@pytest.mark.parametrize('smoothing_time', [0, 0.1])
def test_a_leap_is_no_way_that_ink_was_laid_on(smoothing_time: float) -> None:
    tracker, times = PrintTracker(PathConfig(smoothing_time=smoothing_time)), np.arange(0, 4, 0.01)
    for sample in states_until(4.0, 0.02):
        tracker.add_extruder(sample)
    for time in times:
        there = SPEED * (1.0 if 1 < time < 2 else time)
        assert tracker.add_pose(at_ns(time), np.array((there, 0.0, 0.0)))
    assert tracker.leaps == 1
    path = tracker.path()
    assert path is not None
    x = path.points[:, 0]
    assert not ((x > 10.3 * MM) & (x < 19.7 * MM)).any()
    assert x[-1] > 38 * MM
    assert (np.diff(path.arc_length)[np.diff(x) < 0.3 * MM] < 0.21 * MM).all()


def test_a_clock_that_is_set_back_onto_a_known_stamp_begins_anew() -> None:
    """A pose of a known stamp came after later ones that were in doubt, and divided by zero."""
    whereabouts = Whereabouts()
    for stamp, x in ((0, 0.0), (20, 0.0002), (2000, 0.03), (2020, 0.03), (20, 0.0002)):
        whereabouts.add(stamp * 10**6, np.array((x, 0.0, 0.0)))
    assert whereabouts.certain_ns == 20 * 10**6
