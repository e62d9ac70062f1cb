"""The path of a print: exact, and the same however its input arrives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from perception_builders import (
    along_x,
    assemble,
    at_ns,
    path_bytes,
    SPEED,
    START_NS,
    state,
    states_until,
)
import pytest

from bpc_perception.core.config import PathConfig
from bpc_perception.core.extruder.sample import ExtruderSample
from bpc_perception.core.path import joiner
from bpc_perception.core.path.assembler import PathAssembler
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.growing_path import GrowingPath

RAW = PathConfig(smoothing_time=0)


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
    times = np.arange(0, 2 * np.pi * radius / speed * 2 + 0.3, 0.005)  # twice round, and more
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
    # The way across the hole is part of the length.
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
    # Averaging over an arc makes its radius smaller.
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
    path = path.until(at_ns(1.4))
    expected = np.searchsorted((0.405, 0.713, 1.111), path.time)
    np.testing.assert_array_equal(path.extruding, np.array((0, 1, 0, 1), bool)[expected])
    np.testing.assert_allclose(path.plunger_velocity,
                               np.array((0, 0.405, 0.713, 1.111))[expected])
    np.testing.assert_allclose(path.flow_rate, 2 * path.plunger_velocity)
    assert path.extruder_known.all()  # also where it does not push


def test_between_two_states_of_pushing_the_slower_holds() -> None:
    """The first pushes fast, to make up for a retraction, before the nozzle leaves."""
    fast, slow = (ExtruderSample(START_NS + round(time * 1e9), True, rate, 2 * rate)
                  for time, rate in ((0.0, 5.0), (0.405, 1.0)))
    path = line_with([fast, slow, state(0.713, False), state(1.111)]).until(at_ns(1.3))
    np.testing.assert_array_equal(path.plunger_velocity[path.time < 0.71], 1.0)
    np.testing.assert_array_equal(path.flow_rate[path.time < 0.71], 2.0)
    assert path.extruding[path.time < 0.71].all()


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
    np.testing.assert_array_equal(path.extruder_known, path.extruding)


def test_without_extruder_the_path_follows_after_the_timeout() -> None:
    path = line_with([])
    assert path.complete_until == pytest.approx(2.99 - 0.5)
    assert path.time[-1] == pytest.approx(2.48, abs=0.021)
    assert np.isnan(path.flow_rate).all()
    assert not path.extruding.any()
    assert not path.extruder_known.any()


def test_states_that_arrive_after_the_poses_still_count() -> None:
    times = np.arange(0, 1, 0.01)
    assembler = assemble(times, along_x(times), [state(0)])
    assert assembler.path().complete_until == pytest.approx(0.49)
    assembler.add_extruder(state(0.45, False))
    assembler.add_extruder(state(0.9))
    path = assembler.path()
    late = (path.time > 0.46) & (path.time < 0.89)
    # Points that were certain by then stay; those that follow have the late state.
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
            feed.append((time, 0, (at_ns(time), tip)))
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
        assert path_bytes(path) == path_bytes(whole)
        assert path.complete_until == whole.complete_until
        for earlier in between:
            assert path_bytes(earlier) == path_bytes(whole, len(earlier))


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
    assembler.stop(at_ns(1.0))
    for time in np.arange(1.4, 3, 0.01):
        assembler.add_pose(at_ns(time), along_x(np.array([time]))[0])
    path = assembler.path()
    assert path.finished
    assert path.complete_until == 1.0
    assert path.time[-1] == pytest.approx(1.0, abs=0.021)
    assert path.time[-1] <= 1.0


def test_a_print_stopped_late_keeps_what_was_given_out() -> None:
    times = np.arange(0, 3, 0.01)
    assembler = assemble(times, along_x(times), states_until(2.6))
    before = assembler.path()
    assembler.stop(at_ns(1.0))
    after = assembler.path()
    assert path_bytes(after) == path_bytes(before)
    assert after.finished
    assert after.complete_until == before.complete_until


def test_a_print_is_finished_only_when_its_end_is_known() -> None:
    times = np.arange(0, 1, 0.01)
    assembler = assemble(times, along_x(times), states_until(1.1))
    assembler.stop(at_ns(1.5))
    assert not assembler.path().finished
    for time in np.arange(1, 2, 0.01):
        assembler.add_pose(at_ns(time), along_x(np.array([time]))[0])
    assembler.add_extruder(state(1.9))
    path = assembler.path()
    assert path.finished
    assert path.time[-1] == pytest.approx(1.5, abs=0.021)


def test_a_finished_path_does_not_change_any_more() -> None:
    times = np.arange(0, 3, 0.01)
    assembler = assemble(times[:200], along_x(times[:200]), [state(0.9)])
    assembler.stop(at_ns(1.6))
    assembler.add_extruder(state(1.8))
    before = assembler.path()
    assert before.finished
    for time in times[200:]:
        assembler.add_pose(at_ns(time), along_x(np.array([time]))[0])
    assembler.add_extruder(state(2.9))
    after = assembler.path()
    assert path_bytes(after) == path_bytes(before)
    # Otherwise it would be published for ever.
    assert (after.complete_until, after.finished) == (before.complete_until, before.finished)


def test_states_do_not_pile_up_where_no_poses_come(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(joiner, 'MAXIMUM_WAITING_STATES', 100)
    made = PathAssembler(GrowingPath('print', START_NS), RAW)
    for sample in states_until(100):
        made.add_extruder(sample)
        made.path()
        joined = made._joiner
        assert len(joined._states) == len(joined._state_times) <= 100
    times = np.arange(99, 99.9, 0.01)
    for time, tip in zip(times, along_x(times), strict=True):
        made.add_pose(at_ns(time), tip)
    assert made.path().extruding.all()
    assert len(made.path()) > 30
