"""The path of a print: exact, and the same however its input arrives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from perception_builders import assemble, feed, path_through, SECOND, START_NS, state
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import PathConfig
from bpc_perception.core.extruder.sample import ExtruderSample
from bpc_perception.core.path import assembler
from bpc_perception.core.path.assembler import PathAssembler
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.growing_path import GrowingPath
from bpc_perception.core.path.tracker import JumpError, PrintTracker

RAW = PathConfig(smoothing_time=0)
SPEED = 0.01


def along_x(times: Array, speed: float = SPEED) -> Array:
    """Positions (N, 3) on the x axis at times (N,)."""
    return np.column_stack((speed * times, np.zeros((len(times), 2))))


def states_until(end: float, period: float = 0.1) -> list[ExtruderSample]:
    return [state(time) for time in np.arange(0, end, period)]


def ns(time: float) -> int:
    return START_NS + round(time * SECOND)


# Resampling


def test_a_straight_line_is_resampled_exactly() -> None:
    times = np.arange(0, 2.0001, 0.01)  # a pose each 0.1 mm
    path = assemble(times, along_x(times), states_until(2.1),
                    PathConfig(smoothing_time=0, spacing=2.5e-4)).path()
    k = np.arange(len(path))
    assert len(path) == 81
    np.testing.assert_allclose(path.points, along_x(0.025 * k), atol=1e-12)
    np.testing.assert_allclose(path.arc_length, 2.5e-4 * k, atol=1e-12)
    np.testing.assert_allclose(path.time, 0.025 * k, atol=1e-9)


def test_poses_further_apart_than_the_spacing_are_interpolated() -> None:
    times = np.array((0.0, 0.15, 0.3, 0.41))  # a pose each 1.5 mm
    path = assemble(times, along_x(times), states_until(0.6)).path()
    np.testing.assert_allclose(path.points[:, 0], 2e-4 * np.arange(21), atol=1e-12)
    np.testing.assert_allclose(path.time, 0.02 * np.arange(21), atol=1e-9)


def test_smoothing_leaves_uniform_motion_as_it_is() -> None:
    times = np.arange(0, 3.0001, 0.01)
    path = assemble(times, along_x(times), states_until(3.1), PathConfig()).path()
    # From the first point on, though no poses before the start enter it.
    assert path.time[0] == 0
    np.testing.assert_allclose(path.points, along_x(path.time), atol=1e-9)
    np.testing.assert_allclose(np.diff(path.arc_length), 2e-4, rtol=1e-9)
    assert path.time[-1] == pytest.approx(2.95, abs=0.03)


def test_smoothing_leaves_uniform_motion_as_it_is_with_irregular_poses() -> None:
    times = np.cumsum(np.random.default_rng(5).exponential(0.01, 300))
    path = assemble(times, along_x(times), states_until(times[-1] + 0.2), PathConfig()).path()
    np.testing.assert_allclose(path.points, along_x(path.time), atol=1e-9)
    assert (np.diff(path.time) > 0).all()


@pytest.mark.parametrize(('gap', 'bridged'), [(0.19, True), (0.22, False)])
def test_smoothing_does_not_change_what_counts_as_missing(gap: float, bridged: bool) -> None:
    times = np.concatenate((np.arange(0, 1.0001, 0.01), 1 + np.arange(gap, 2, 0.01)))
    path = assemble(times, along_x(times), states_until(3.1), PathConfig()).path()
    between = (path.time > 1.01) & (path.time < 1 + gap - 0.01)
    assert between.any() == bridged


@pytest.mark.parametrize('smoothing_time', [0, 0.1])
def test_a_circle_has_its_circumference(smoothing_time: float) -> None:
    radius, speed = 0.015, 3e-3
    times = np.arange(0, 2 * np.pi * radius / speed * 2 + 0.3, 0.005)  # twice round, and some
    angle = times * speed / radius
    tips = radius * np.column_stack((np.cos(angle), np.sin(angle), np.zeros(len(angle))))
    path = assemble(times, tips, states_until(times[-1] + 0.1),
                    PathConfig(smoothing_time=smoothing_time)).path()
    turned = np.unwrap(np.arctan2(path.points[:, 1], path.points[:, 0]))
    np.testing.assert_allclose(path.arc_length[-1], radius * (turned[-1] - turned[0]), rtol=1e-3)
    assert turned[-1] > 4 * np.pi
    np.testing.assert_allclose(np.hypot(*path.points[:, :2].T), radius, rtol=1e-3)


def test_neighbours_are_one_spacing_apart_on_any_curve() -> None:
    times = np.arange(0, 20, 0.01)
    tips = 0.01 * np.column_stack((np.sin(times), np.sin(2.3 * times), 0.3 * np.cos(times)))
    path = assemble(times, tips, states_until(20.1)).path()
    steps = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
    np.testing.assert_allclose(steps, 2e-4, rtol=1e-6)
    assert (np.diff(path.time) > 0).all()


@pytest.mark.parametrize('smoothing_time', [0, 0.1])
def test_a_robot_that_trembles_on_the_spot_adds_no_length(smoothing_time: float) -> None:
    rng = np.random.default_rng(1)
    times = np.arange(0, 30, 0.01)
    tips = rng.uniform(-4e-5, 4e-5, (len(times), 3))
    path = assemble(times, tips, states_until(30),
                    PathConfig(smoothing_time=smoothing_time)).path()
    assert path.arc_length.tolist() == [0]


def test_a_pause_on_the_way_adds_no_length() -> None:
    times = np.arange(0, 6, 0.01)
    x = SPEED * (np.clip(times, 0, 1) + np.clip(times - 4, 0, None))
    path = assemble(times, np.column_stack((x, 0 * x, 0 * x)), states_until(6.2)).path()
    np.testing.assert_allclose(path.points[:, 0], path.arc_length, atol=1e-12)
    assert path.arc_length[-1] == pytest.approx(0.0299, abs=2e-4)


def test_no_points_are_invented_where_poses_are_missing() -> None:
    times = np.concatenate((np.arange(0, 1.0001, 0.01), np.arange(2, 3.0001, 0.01)))
    path = assemble(times, along_x(times), states_until(3.1)).path()
    assert not ((path.time > 1) & (path.time < 2)).any()
    assert (path.time == 2).any()
    # The way across is part of the length.
    np.testing.assert_allclose(path.arc_length, path.points[:, 0], atol=1e-12)


@pytest.mark.parametrize('smoothing_time', [0, 0.1])
def test_a_curve_is_not_cut_short_where_poses_are_missing(smoothing_time: float) -> None:
    radius, speed, hole = 0.005, 0.03, (0.5, 0.8)
    times = np.arange(0, 1.5, 0.005)
    times = times[(times <= hole[0]) | (times >= hole[1])]
    angle = times * speed / radius
    tips = radius * np.column_stack((np.cos(angle), np.sin(angle), np.zeros(len(angle))))
    path = assemble(times, tips, states_until(1.5),
                    PathConfig(smoothing_time=smoothing_time)).path()
    # What averaging over an arc takes off its radius.
    half = smoothing_time / 2 * speed / radius
    averaged = radius * np.sinc(half / np.pi)
    off = np.hypot(*path.points[:, :2].T)
    assert averaged - 5e-5 < off.min()
    assert off.max() < radius + 5e-5
    steps = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
    (before,) = np.flatnonzero(steps > 1e-3)  # the one jump is the hole
    assert path.time[before] <= hole[0]
    assert path.time[before + 1] >= hole[1]
    chord = 2 * radius * np.sin((hole[1] - hole[0]) * speed / radius / 2)
    assert steps[before] == pytest.approx(chord, rel=0.25)


def test_short_gaps_between_poses_are_bridged() -> None:
    times = np.concatenate((np.arange(0, 1.0001, 0.01), np.arange(1.19, 3, 0.01)))
    path = assemble(times, along_x(times), states_until(3.1)).path()
    np.testing.assert_allclose(np.diff(path.points[:, 0]), 2e-4, atol=1e-12)


# Joining with the extruder


def line_with(states: list[ExtruderSample], end: float = 3.0) -> DepositionPath:
    times = np.arange(0, end, 0.01)
    return assemble(times, along_x(times), states).path()


def test_an_extruder_state_holds_until_the_next() -> None:
    path = line_with([state(0, False), state(0.405), state(0.713, False), state(1.111)])
    path = path.until(ns(1.4))
    expected = np.searchsorted((0.405, 0.713, 1.111), path.time)
    np.testing.assert_array_equal(path.extruding, np.array((0, 1, 0, 1), bool)[expected])
    np.testing.assert_allclose(path.plunger_velocity,
                               np.array((0, 0.405, 0.713, 1.111))[expected])
    np.testing.assert_allclose(path.flow_rate, 2 * path.plunger_velocity)


def test_a_state_from_before_the_start_holds() -> None:
    path = line_with([state(-0.2), state(0.3)])
    assert path.extruding[path.time < 0.29].all()


def test_an_old_state_is_not_believed() -> None:
    path = line_with([state(0), state(1.5)])
    unknown = (path.time > 0.505) & (path.time < 1.495)
    assert unknown.sum() > 40
    assert np.isnan(path.plunger_velocity[unknown]).all()
    assert np.isnan(path.flow_rate[unknown]).all()
    assert not path.extruding[unknown].any()
    assert path.extruding[path.time < 0.495].all()
    assert path.extruding[path.time > 1.505].any()


def test_without_extruder_the_path_follows_after_the_timeout() -> None:
    path = line_with([])
    assert path.complete_until == pytest.approx(2.99 - 0.5)
    assert path.time[-1] == pytest.approx(2.48, abs=0.021)
    assert np.isnan(path.flow_rate).all()
    assert not path.extruding.any()


def test_states_that_arrive_after_the_poses_still_count() -> None:
    times = np.arange(0, 1, 0.01)
    assembler = assemble(times, along_x(times), [state(0)])
    assert assembler.path().complete_until == pytest.approx(0.49)
    assembler.add_extruder(state(0.45, False))
    assembler.add_extruder(state(0.9))
    path = assembler.path()
    late = (path.time > 0.46) & (path.time < 0.89)
    # What was certain by then stays; what follows has the late state.
    np.testing.assert_allclose(path.plunger_velocity[late & (path.time > 0.5)], 0.45)
    assert not path.extruding[late & (path.time > 0.5)].any()


# What is certain, and stays


class Split:
    """A print fed message by message, with calls of path() wherever they are asked for."""

    def __init__(self, seed: int, delay: float) -> None:
        rng = np.random.default_rng(seed)
        times = np.cumsum(rng.uniform(1e-3, 0.02, 600))
        times[400:] += 0.8  # the poses are missing for a while
        tips = np.cumsum(rng.normal(0, 5e-5, (600, 3)), axis=0) + along_x(times)
        stamps = np.cumsum(rng.uniform(0.02, 0.15, 80))
        stamps[40:] += 1.2  # and the extruder's states
        feed: list[tuple[float, int, Any]] = []
        arrival = 0.0
        for time, tip in zip(times, tips, strict=True):
            feed.append((time, 0, (ns(time), tip)))
        for number, stamp in enumerate(stamps):
            arrival = max(arrival, stamp + rng.uniform(0, delay))
            feed.append((arrival, 1, state(stamp, bool(number % 7))))
        self.feed = sorted(feed, key=lambda item: item[:2])

    def run(self, ask: Callable[[int], bool],
            config: PathConfig) -> tuple[DepositionPath, list[DepositionPath]]:
        assembler = PathAssembler(GrowingPath('print', START_NS), config)
        between = []
        for number, (_, kind, content) in enumerate(self.feed):
            if kind == 0:
                assembler.add_pose(*content)
            else:
                assembler.add_extruder(content)
            if ask(number):
                between.append(assembler.path())
        return assembler.path(), between


def numbers(path: DepositionPath, count: int | None = None) -> list[bytes]:
    """The arrays of the first ``count`` points to the last bit."""
    return [array[:count].tobytes() for array in (
        path.time, path.arc_length, path.points, path.plunger_velocity, path.flow_rate,
        path.extruding)]


@pytest.mark.parametrize('smoothing_time', [0, 0.1])
@pytest.mark.parametrize('delay', [0.0, 0.3, 1.5])
@pytest.mark.parametrize('seed', range(4))
def test_the_path_is_the_same_however_the_input_is_split(seed: int, delay: float,
                                                         smoothing_time: float) -> None:
    split, config = Split(seed, delay), PathConfig(smoothing_time=smoothing_time)
    whole, _ = split.run(lambda _: False, config)
    assert len(whole) > 100
    rng = np.random.default_rng(seed)
    for share in (0.01, 0.1, 1):
        path, between = split.run(lambda _, share=share: rng.random() < share, config)
        assert numbers(path) == numbers(whole)
        assert path.complete_until == whole.complete_until
        for earlier in between:
            assert numbers(earlier) == numbers(whole, len(earlier))


@pytest.mark.parametrize('smoothing_time', [0, 0.1])
@pytest.mark.parametrize('delay', [0.0, 0.3, 1.5])
def test_no_point_follows_before_the_time_said_to_be_complete(delay: float,
                                                              smoothing_time: float) -> None:
    split, config = Split(7, delay), PathConfig(smoothing_time=smoothing_time)
    whole, between = split.run(lambda number: number % 5 == 0, config)
    for earlier in between:
        assert (whole.time[len(earlier):] > earlier.complete_until - 1e-9).all()
        assert len(earlier) == 0 or earlier.time[-1] <= earlier.complete_until


def test_nothing_is_certain_before_the_first_pose() -> None:
    path = PathAssembler(GrowingPath('print', START_NS), RAW).path()
    assert len(path) == 0
    assert path.complete_until == -np.inf
    assert not path.covers(START_NS)


def test_a_stopped_print_ends_at_its_stamp() -> None:
    times = np.arange(0, 1.4, 0.01)
    assembler = assemble(times, along_x(times), [state(0.9)])
    assembler.stop(ns(1.0))
    for time in np.arange(1.4, 3, 0.01):
        assembler.add_pose(ns(time), along_x(np.array([time]))[0])
    path = assembler.path()
    assert path.finished
    assert path.complete_until == 1.0
    assert path.time[-1] == pytest.approx(1.0, abs=0.021)
    assert path.time[-1] <= 1.0


def test_a_print_stopped_late_keeps_what_was_given_out() -> None:
    times = np.arange(0, 3, 0.01)
    assembler = assemble(times, along_x(times), states_until(2.6))
    before = assembler.path()
    assembler.stop(ns(1.0))
    after = assembler.path()
    assert numbers(after) == numbers(before)
    assert after.finished
    assert after.complete_until == before.complete_until


def test_a_print_is_finished_only_when_its_end_is_known() -> None:
    times = np.arange(0, 1, 0.01)
    assembler = assemble(times, along_x(times), states_until(1.1))
    assembler.stop(ns(1.5))
    assert not assembler.path().finished
    for time in np.arange(1, 2, 0.01):
        assembler.add_pose(ns(time), along_x(np.array([time]))[0])
    assembler.add_extruder(state(1.9))
    path = assembler.path()
    assert path.finished
    assert path.time[-1] == pytest.approx(1.5, abs=0.021)


def test_a_finished_path_does_not_change_any_more() -> None:
    times = np.arange(0, 3, 0.01)
    assembler = assemble(times[:200], along_x(times[:200]), [state(0.9)])
    assembler.stop(ns(1.6))
    assembler.add_extruder(state(1.8))
    before = assembler.path()
    assert before.finished
    for time in times[200:]:
        assembler.add_pose(ns(time), along_x(np.array([time]))[0])
    assembler.add_extruder(state(2.9))
    after = assembler.path()
    assert numbers(after) == numbers(before)
    # Otherwise it would be published for ever.
    assert (after.complete_until, after.finished) == (before.complete_until, before.finished)


# The path object


def test_until_gives_what_was_passed_by_then() -> None:
    path = path_through(along_x(np.linspace(0, 1, 11)))
    assert len(path.until(ns(0.5))) == 6
    assert len(path.until(ns(0.55))) == 6
    assert len(path.until(ns(-0.1))) == 0
    part = path.until(ns(99))
    assert len(part) == len(part.points) == len(part.extruding) == len(part.flow_rate) == 11


@pytest.mark.parametrize(('finished', 'time', 'covered'), [
    (False, 0.9, True), (False, 1.0, True), (False, 1.1, False), (True, 1.1, True)])
def test_a_path_covers_what_is_complete(finished: bool, time: float, covered: bool) -> None:
    path = path_through(along_x(np.linspace(0, 1, 11)), finished=finished)
    assert path.covers(ns(time)) == covered


def test_states_do_not_pile_up_where_no_poses_come(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assembler, 'MAXIMUM_STATES', 100)
    made = PathAssembler(GrowingPath('print', START_NS), RAW)
    for sample in states_until(100):
        made.add_extruder(sample)
        made.path()
        assert len(made._states) == len(made._state_times) <= 100
    times = np.arange(99, 99.9, 0.01)
    for time, tip in zip(times, along_x(times), strict=True):
        made.add_pose(ns(time), tip)
    assert made.path().extruding.all()
    assert len(made.path()) > 30


# Starting and stopping


def tracker_fed(config: PathConfig, poses: Array, states: list[ExtruderSample]) -> PrintTracker:
    tracker = PrintTracker(config)
    feed(tracker, poses, along_x(poses), states)
    return tracker


AUTO = PathConfig(smoothing_time=0, auto_stop_after=1.0)


def test_a_print_starts_with_the_stamp_of_the_first_extrusion() -> None:
    poses = np.arange(0, 3, 0.01)
    tracker = tracker_fed(AUTO, poses, [state(0.5, False)])
    tracker.add_extruder(state(1.0))
    path = tracker.path()
    assert path is not None
    assert path.start_ns == ns(1.0)
    # The poses had all arrived before; those from before the start do not count.
    np.testing.assert_allclose(path.points[0], (SPEED * 1.0, 0, 0), atol=1e-12)
    assert path.time[-1] == pytest.approx(1.49, abs=0.021)
    assert path.extruding[path.time < 0.49].all()


@pytest.mark.parametrize('smoothing_time', [0, 0.1])
@pytest.mark.parametrize('lag', [-0.3, 0.02, 0.3])
def test_a_print_is_the_same_whichever_topic_is_ahead(lag: float, smoothing_time: float) -> None:
    # Poses and states come on two topics; a busy recorder may hear of one before the other.
    config = PathConfig(smoothing_time=smoothing_time)
    times = np.arange(0, 3, 0.01)
    states = [state(t, t > 0.99) for t in np.arange(0, 3, 0.02)]

    def run(lag: float) -> DepositionPath:
        tracker = PrintTracker(config)
        events: list[tuple[float, int, Any]] = [
            (time + lag, 0, (ns(time), tip))
            for time, tip in zip(times, along_x(times), strict=True)]
        events += [((sample.stamp_ns - START_NS) / SECOND, 1, sample) for sample in states]
        for _, kind, content in sorted(events, key=lambda event: event[:2]):
            if kind:
                tracker.add_extruder(content)
            else:
                tracker.add_pose(*content)
        path = tracker.path()
        assert path is not None
        return path

    in_step, apart = run(0.0), run(lag)
    assert in_step.time[0] == 0
    assert len(in_step) > 80
    assert numbers(apart) == numbers(in_step)


def test_without_auto_nothing_starts_by_itself() -> None:
    config = PathConfig(auto=False)
    assert tracker_fed(config, np.arange(0, 1, 0.01), [state(0.5)]).path() is None


def test_a_print_stops_some_time_after_the_last_extrusion() -> None:
    poses = np.arange(0, 4.5, 0.01)
    states = [state(t, 0.5 <= t < 1.55) for t in np.arange(0, 4.5, 0.1)]
    path = tracker_fed(AUTO, poses, states).path()
    assert path is not None
    assert path.finished
    # Started at 0.5, ink until 1.5, then one second more.
    assert path.time[-1] == pytest.approx(2.0, abs=0.021)
    assert path.time[-1] <= 2.0 + 1e-9


def test_a_pause_shorter_than_that_does_not_stop_it() -> None:
    poses = np.arange(0, 4.5, 0.01)
    states = [state(t, not 1 < t < 1.95) for t in np.arange(0, 4.5, 0.1)]
    path = tracker_fed(AUTO, poses, states).path()
    assert path is not None
    assert not path.finished
    assert path.time[-1] > 4


def test_an_extruder_silent_for_longer_than_that_has_stopped() -> None:
    poses = np.arange(0, 4.5, 0.01)
    states = [state(t) for t in np.arange(0, 4.5, 0.1) if not 1.05 < t < 2.95]
    path = tracker_fed(AUTO, poses, states).path()
    assert path is not None
    assert path.start_ns == pytest.approx(ns(3.0), abs=1000)


def test_the_next_extrusion_starts_another_print() -> None:
    poses = np.arange(0, 4.5, 0.01)
    states = [state(t, t < 0.5 or t > 3) for t in np.arange(0, 4.5, 0.1)]
    path = tracker_fed(AUTO, poses, states).path()
    assert path is not None
    assert path.start_ns == pytest.approx(ns(3.1), abs=1000)
    assert not path.finished


@pytest.mark.parametrize('repeat', [0, -1], ids=['repeated', 'late'])
def test_late_and_repeated_poses_are_refused(repeat: int) -> None:
    tracker = PrintTracker(RAW)
    assert tracker.add_pose(START_NS, np.zeros(3))
    assert not tracker.add_pose(START_NS + repeat, np.ones(3))
    assert tracker.add_pose(START_NS + 1, np.zeros(3))


@pytest.mark.parametrize('repeat', [0, -0.1], ids=['repeated', 'late'])
def test_late_and_repeated_states_are_refused(repeat: float) -> None:
    tracker = PrintTracker(RAW)
    assert tracker.add_extruder(state(0, False))
    assert not tracker.add_extruder(state(repeat))
    assert tracker.path() is None


def test_start_and_stop_by_hand() -> None:
    poses = np.arange(0, 1.3, 0.01)
    tracker = tracker_fed(PathConfig(smoothing_time=0, auto=False), poses, states_until(1.3))
    name = tracker.start(ns(0.5))
    assert tracker.stop(ns(1.5))
    more = np.arange(1.3, 3, 0.01)
    feed(tracker, more, along_x(more), states_until(3)[13:])
    path = tracker.path()
    assert path is not None
    assert (path.print_id, path.start_ns, path.finished) == (name, ns(0.5), True)
    assert path.time[0] == 0
    assert path.time[-1] == pytest.approx(1.0, abs=0.021)


def test_a_print_started_by_hand_knows_the_states_before() -> None:
    poses = np.arange(0, 3, 0.01)
    tracker = tracker_fed(PathConfig(smoothing_time=0, auto=False), poses, states_until(3))
    tracker.start(ns(0.5))
    path = tracker.path()
    assert path is not None
    assert path.time[-1] > 2
    assert path.extruding.all()


def test_only_a_running_print_can_be_stopped() -> None:
    tracker = PrintTracker(RAW)
    assert not tracker.stop(START_NS)
    tracker.start(START_NS)
    assert tracker.stop(START_NS + SECOND)
    assert not tracker.stop(START_NS + SECOND)


def test_a_print_is_named_after_its_start() -> None:
    assert PrintTracker(RAW).start(START_NS + 42_999_999) == '20231114T221320.042Z'


def test_clear_forgets_the_print_and_takes_earlier_stamps() -> None:
    tracker = tracker_fed(AUTO, np.arange(0, 1, 0.01), [state(0.5)])
    assert tracker.path() is not None
    tracker.clear()
    assert tracker.path() is None
    assert tracker.add_pose(START_NS - SECOND, np.zeros(3))
    assert tracker.add_extruder(state(-1, False))
    assert not tracker.stop(START_NS)


@pytest.mark.parametrize('pause', [0, 3])
def test_an_automatic_stop_is_the_same_however_often_the_path_is_asked_for(pause: int) -> None:
    # The extruder falls silent, and is back after the print should have ended.
    def run(every: int) -> DepositionPath:
        tracker = PrintTracker(AUTO)
        for number, time in enumerate(np.arange(0, 6, 0.01)):
            tracker.add_pose(ns(time), along_x(np.array([time]))[0])
            if number % 10 == 0 and not 1 < time < 1 + pause:
                tracker.add_extruder(state(time, time < 1.05))
            if number % every == 0:
                tracker.path()
        path = tracker.path()
        assert path is not None
        return path

    seldom, often = run(10_000), run(1)
    assert seldom.finished
    assert numbers(often) == numbers(seldom)


# Poses that jump


def jumping(count: int, to: float = 0.5) -> tuple[PrintTracker, list[int]]:
    """A line at 10 mm/s with 100 poses a second, of which some after the 100th are elsewhere."""
    tracker = PrintTracker(PathConfig(smoothing_time=0.0, maximum_speed=2.0))
    tracker.add_extruder(state(0.0))
    refused = []
    for number in range(300):
        away = to if 100 <= number < 100 + count else 0.0
        if number % 10 == 0 and number:
            tracker.add_extruder(state(number / 100))
        try:
            tracker.add_pose(ns(number / 100), np.array((1e-4 * number, away, 0.0)))
        except JumpError:
            refused.append(number)
    return tracker, refused


@pytest.mark.parametrize('count', [1, 5])
def test_a_pose_that_jumps_is_refused_and_the_path_goes_on(count: int) -> None:
    tracker, refused = jumping(count)
    assert refused == list(range(100, 100 + count))
    path = tracker.path()
    assert path is not None
    np.testing.assert_allclose(path.points[:, 1:], 0, atol=1e-12)
    assert path.arc_length[-1] == pytest.approx(1e-4 * 290, abs=3e-4)


def test_a_jump_that_lasts_is_believed_when_there_was_time_to_get_there() -> None:
    tracker, refused = jumping(200, to=1.5)
    # 1.5 m at 2 m/s, less what counts as jitter.
    assert refused == list(range(100, 99 + 75))
    path = tracker.path()
    assert path is not None
    assert set(path.points[:, 1].round(9)) == {0.0, 1.5}  # the way there is unknown


def test_a_first_pose_that_is_wrong_does_not_stop_the_rest() -> None:
    tracker = PrintTracker(PathConfig(maximum_speed=2.0))
    tracker.add_pose(START_NS, np.array((0.5, 0.0, 0.0)))
    taken = []
    for number in range(1, 100):
        try:
            taken.append(tracker.add_pose(START_NS + number * 10**7, np.zeros(3)))
        except JumpError:
            assert not taken
    assert len(taken) == 100 - 25


# Prints that are gone on with


def printed(tracker: PrintTracker, start: float, end: float) -> None:
    """A line at 10 mm/s from one time to another, ink flowing."""
    times = np.arange(round(start * 100), round(end * 100)) / 100
    feed(tracker, times, along_x(times), [state(time) for time in times[::10]])


def left_off() -> tuple[GrowingPath, DepositionPath]:
    """A print after two seconds."""
    tracker = PrintTracker(PathConfig())
    printed(tracker, 0.0, 2.0)
    path = tracker.growing_path()
    assert path is not None
    return path, path.path()


@pytest.mark.parametrize('away', [0.3, 3.0, 20.0])  # also longer than what ends a print by itself
def test_a_print_left_off_goes_on_with_a_gap_where_nobody_listened(away: float) -> None:
    path, before = left_off()
    tracker = PrintTracker(PathConfig())
    tracker.resume(path, ns(2.0 + away))
    printed(tracker, 2.0 + away, 5.0 + away)
    after = tracker.path()
    assert after is not None
    assert (after.print_id, after.start_ns) == (before.print_id, before.start_ns)
    for name in ('time', 'arc_length', 'points', 'flow_rate'):
        np.testing.assert_array_equal(getattr(after, name)[:len(before)], getattr(before, name))
    new = after.where(np.arange(len(after)) >= len(before))
    assert new.time[0] == pytest.approx(2.0 + away, abs=0.02)
    assert new.extruding.all()
    # No point is where nobody listened, and arc length goes on across it.
    assert np.diff(after.points[:, 0]).max() == pytest.approx(
        new.points[0, 0] - before.points[-1, 0])
    np.testing.assert_allclose(after.arc_length, after.points[:, 0], atol=1e-9)
    assert not after.finished


def test_a_print_left_off_takes_no_poses_it_has_already() -> None:
    path, _ = left_off()
    tracker = PrintTracker(PathConfig())
    tracker.resume(path, ns(2.0))
    printed(tracker, 1.0, 4.0)  # the last second once more
    after = tracker.path()
    assert after is not None
    assert (np.diff(after.time) > 0).all()
    np.testing.assert_allclose(after.arc_length, after.points[:, 0], atol=1e-9)


def test_a_print_left_off_is_complete_as_far_as_it_was() -> None:
    path, before = left_off()
    tracker = PrintTracker(PathConfig())
    tracker.resume(path, ns(2.0))
    for path_now in (tracker.path(), tracker.path()):
        assert path_now is not None
        assert path_now.complete_until == before.complete_until


def test_a_print_left_off_still_ends_by_itself() -> None:
    path, _ = left_off()
    tracker = PrintTracker(PathConfig(auto_stop_after=1.0))
    tracker.resume(path, ns(5.0))
    times = np.arange(500, 800) / 100
    feed(tracker, times, along_x(times), [state(time, False) for time in times[::10]])
    after = tracker.path()
    assert after is not None
    assert after.finished
    assert after.complete_until == pytest.approx(6.0)


# Prints of any length


def test_a_print_of_one_point() -> None:
    tracker = PrintTracker(RAW)
    for number in range(100):
        tracker.add_extruder(state(number / 100))
        tracker.add_pose(ns(number / 100), np.zeros(3))
    path = tracker.path()
    assert path is not None
    assert len(path) == 1
    assert path.arc_length.tolist() == [0.0]


def test_two_prints_back_to_back_share_nothing() -> None:
    tracker = PrintTracker(PathConfig(auto_stop_after=0.5, smoothing_time=0.0))
    times = np.arange(0, 600) / 100
    extruding = (times < 2.0) | (times >= 4.0)
    feed(tracker, times[:400], along_x(times)[:400],
         [state(time, bool(on)) for time, on in zip(times, extruding, strict=True)][:400:10])
    first = tracker.path()
    feed(tracker, times[400:], along_x(times)[400:],
         [state(time, bool(on)) for time, on in zip(times, extruding, strict=True)][400::10])
    second = tracker.path()
    assert first is not None
    assert second is not None
    assert first.finished
    assert not second.finished
    assert first.print_id != second.print_id
    assert first.points[-1, 0] < 0.026
    assert second.points[0, 0] == pytest.approx(0.04, abs=1e-3)
    assert second.arc_length[0] == 0.0


def test_a_clock_that_jumps_forward_ends_the_print_and_bridges_nothing() -> None:
    tracker = PrintTracker(PathConfig())
    printed(tracker, 0.0, 2.0)
    before = tracker.path()
    printed(tracker, 3600.0, 3602.0)
    after = tracker.path()
    assert before is not None
    assert after is not None
    assert after.print_id != before.print_id
    assert after.start_ns == ns(3600.0)
    assert after.time[0] < 0.1


def test_a_robot_at_1000_hz_fills_no_memory() -> None:
    """What is kept beside the path is what smoothing and a start of a print need."""
    tracker = PrintTracker(PathConfig())
    for number in range(30_000):
        if number % 20 == 0:
            tracker.add_extruder(state(number / 1000))
            path = tracker.growing_path()
        tracker.add_pose(ns(number / 1000), np.array((3e-6 * number, 0.0, 0.0)))
    assert path is not None
    made = tracker._print
    assert made is not None
    assert len(path) == pytest.approx(0.09 / 2e-4, abs=3)
    assert len(tracker._poses) <= 5001  # of the last 5 s
    assert len(tracker._states) <= 251
    assert max(len(made._new), len(made._tail), len(made._knots)) < 300
    assert max(len(made._waiting), len(made._states)) < 30
