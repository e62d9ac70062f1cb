"""Where prints begin and end, and what is kept for that."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from perception_builders import (
    along_x,
    at_ns,
    feed,
    path_bytes,
    SECOND,
    SPEED,
    START_NS,
    state,
    states_until,
)
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import PathConfig
from bpc_perception.core.extruder.sample import ExtruderSample
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.growing_path import GrowingPath
from bpc_perception.core.path.print_id import print_id_of
from bpc_perception.core.path.tracker import JumpError, PrintTracker

RAW = PathConfig(smoothing_time=0)


# Starting and stopping


def tracker_fed(config: PathConfig, poses: Array, states: list[ExtruderSample]) -> PrintTracker:
    tracker = PrintTracker(config)
    feed(tracker, poses, along_x(poses), states)
    return tracker


Event = tuple[float, int, Any]  # time of arrival [s]; 0 and stamp and tip, or 1 and a state


def path_from(tracker: PrintTracker, events: list[Event]) -> DepositionPath:
    """The path after poses and states that arrive in the order of their times."""
    for _, kind, content in sorted(events, key=lambda event: event[:2]):
        if kind:
            tracker.add_extruder(content)
        else:
            tracker.add_pose(*content)
    path = tracker.path()
    assert path is not None
    return path


AUTO = PathConfig(smoothing_time=0, auto_stop_after=1.0)


def test_a_print_starts_with_the_stamp_of_the_first_extrusion() -> None:
    poses = np.arange(0, 3, 0.01)
    tracker = tracker_fed(AUTO, poses, [state(0.5, False)])
    tracker.add_extruder(state(1.0))
    path = tracker.path()
    assert path is not None
    assert path.start_ns == at_ns(1.0)
    # The poses had all arrived before; those from before the start do not count.
    np.testing.assert_allclose(path.points[0], (SPEED * 1.0, 0, 0), atol=1e-12)
    assert path.time[-1] == pytest.approx(1.49, abs=0.021)
    assert path.extruding[path.time < 0.49].all()


@pytest.mark.parametrize('smoothing_time', [0, 0.1])
@pytest.mark.parametrize('lag', [-0.3, 0.02, 0.3])
def test_a_print_is_the_same_whichever_topic_is_ahead(lag: float, smoothing_time: float) -> None:
    # Poses and states come on two topics; a busy recorder may receive one before the other.
    config = PathConfig(smoothing_time=smoothing_time)
    times = np.arange(0, 3, 0.01)
    states = [state(t, t > 0.99) for t in np.arange(0, 3, 0.02)]

    def run(lag: float) -> DepositionPath:
        tracker = PrintTracker(config)
        events: list[Event] = [
            (time + lag, 0, (at_ns(time), tip))
            for time, tip in zip(times, along_x(times), strict=True)]
        events += [((sample.stamp_ns - START_NS) / SECOND, 1, sample) for sample in states]
        return path_from(tracker, events)

    in_step, apart = run(0.0), run(lag)
    assert in_step.time[0] == 0
    assert len(in_step) > 80
    assert path_bytes(apart) == path_bytes(in_step)


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


def test_an_extruder_that_flaps_twenty_times_a_second_makes_one_print_of_short_strokes() -> None:
    tracker = PrintTracker(PathConfig())
    for number in range(4000):  # 100 s
        tracker.add_extruder(ExtruderSample(at_ns(number / 40), number % 2 == 0, 1e-4, 1e-8))
        tracker.add_pose(at_ns(number / 40), along_x(np.array([number / 40]))[0])
    path = tracker.path()
    assert path is not None
    assert path.print_id == print_id_of(at_ns(0.0))
    assert path.arc_length[-1] == pytest.approx(1.0, abs=0.01)
    since, on = np.modf(path.time * 40 % 2)
    inside = (since > 0.2) & (since < 0.8)
    np.testing.assert_array_equal(path.extruding[inside], on[inside] == 0)
    assert path.extruding[inside].sum() > 1000


def test_an_extruder_silent_for_longer_than_that_has_stopped() -> None:
    poses = np.arange(0, 4.5, 0.01)
    states = [state(t) for t in np.arange(0, 4.5, 0.1) if not 1.05 < t < 2.95]
    path = tracker_fed(AUTO, poses, states).path()
    assert path is not None
    assert path.start_ns == pytest.approx(at_ns(3.0), abs=1000)


def test_the_next_extrusion_starts_another_print() -> None:
    poses = np.arange(0, 4.5, 0.01)
    states = [state(t, t < 0.5 or t > 3) for t in np.arange(0, 4.5, 0.1)]
    path = tracker_fed(AUTO, poses, states).path()
    assert path is not None
    assert path.start_ns == pytest.approx(at_ns(3.1), abs=1000)
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
    name = tracker.start(at_ns(0.5))
    assert tracker.stop(at_ns(1.5))
    more = np.arange(1.3, 3, 0.01)
    feed(tracker, more, along_x(more), states_until(3)[13:])
    path = tracker.path()
    assert path is not None
    assert (path.print_id, path.start_ns, path.finished) == (name, at_ns(0.5), True)
    assert path.time[0] == 0
    assert path.time[-1] == pytest.approx(1.0, abs=0.021)


def test_a_print_started_by_hand_knows_the_states_before() -> None:
    poses = np.arange(0, 3, 0.01)
    tracker = tracker_fed(PathConfig(smoothing_time=0, auto=False), poses, states_until(3))
    tracker.start(at_ns(0.5))
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
            tracker.add_pose(at_ns(time), along_x(np.array([time]))[0])
            if number % 10 == 0 and not 1 < time < 1 + pause:
                tracker.add_extruder(state(time, time < 1.05))
            if number % every == 0:
                tracker.path()
        path = tracker.path()
        assert path is not None
        return path

    seldom, often = run(10_000), run(1)
    assert seldom.finished
    assert path_bytes(often) == path_bytes(seldom)


# Pauses

PAUSE = PathConfig(auto_stop_after=1.0)


def stroke(tracker: PrintTracker, begin: float, start: tuple[float, float, float],
           length: float = 0.02) -> None:
    """A stroke along x at 10 mm/s from a place [m], begun at a time [s], after 0.2 s of rest."""
    times = begin + np.arange(-20, round(length * 1e4)) / 100
    tips = np.array(start) + np.maximum(times - begin, 0)[:, None] * (0.01, 0, 0)
    feed(tracker, times, tips, [state(time, bool(time >= begin)) for time in times[::2]])
    tracker.add_extruder(state(float(times[-1]) + 0.01, False))


def identifiers(*starts: tuple[float, float, float], pause: float = 20.0) -> list[str]:
    """The identifier of the print after each of some strokes, with pauses between."""
    tracker, found = PrintTracker(PAUSE), []
    for number, start in enumerate(starts):
        stroke(tracker, 1.0 + number * pause, start)
        path = tracker.path()
        assert path is not None
        found.append(path.print_id)
    return found


def test_a_wall_with_pauses_is_one_print() -> None:
    assert len(set(identifiers(*((0.0, 0.0, 0.2e-3 * layer) for layer in range(10))))) == 1


@pytest.mark.parametrize('start', [(0.0, 0.004, 0.0), (0.024, 0.0, 0.0), (0.01, 0.01, 0.0),
                                   (0.005, 0.0, 0.0004)],
                         ids=['beside', 'behind', 'obliquely', 'above'])
def test_ink_beside_or_above_goes_on_with_the_print(start: tuple[float, float, float]) -> None:
    assert len(set(identifiers((0.0, 0.0, 0.0), start))) == 1


@pytest.mark.parametrize('start', [(0.0, 0.05, 0.0), (0.0, 0.0, 0.0), (0.01, 0.0, -0.01),
                                   (0.01, 0.0, 0.05), (0.01, 0.0, 0.0001)],
                         ids=['away', 'anew', 'below', 'far above', 'on ink'])
def test_ink_elsewhere_or_the_same_once_more_is_another_print(
        start: tuple[float, float, float]) -> None:
    assert len(set(identifiers((0.0, 0.0, 0.0), start))) == 2


def test_ink_goes_on_where_the_nozzle_stopped() -> None:
    assert len(set(identifiers((0.0, 0.0, 0.0), (0.02, 0.0, 0.0)))) == 1


def test_ink_that_flows_on_after_a_stop_is_no_print() -> None:
    tracker = PrintTracker(PAUSE)
    times = np.arange(300) / 100
    feed(tracker, times, np.column_stack((0.01 * times, 0 * times, 0 * times)),
         [state(time, bool(time < 2.5)) for time in times[::2] if time < 1.5])
    first = tracker.path()
    assert first is not None
    tracker.stop(at_ns(1.4))
    for time in np.arange(1.5, 3.0, 0.02):
        tracker.add_extruder(state(float(time), bool(time < 2.5 or time > 2.7)))
        path = tracker.path()
        assert path is not None
        assert (path.print_id == first.print_id) == (time <= 2.7)
    # On request a print starts at once.
    tracker.stop(at_ns(2.99))
    tracker.start(at_ns(3.0))
    tracker.add_extruder(state(3.01))
    path = tracker.path()
    assert path is not None
    assert path.start_ns == at_ns(3.0)


def test_a_day_later_it_is_another_print() -> None:
    starts = (0.0, 0.0, 0.0), (0.0, 0.004, 0.0)
    assert len(set(identifiers(*starts, pause=3500.0))) == 1
    assert len(set(identifiers(*starts, pause=86400.0))) == 2


def test_a_print_that_was_ended_does_not_go_on() -> None:
    for end in (lambda tracker: tracker.stop(at_ns(5.0)), PrintTracker.end):
        tracker = PrintTracker(PAUSE)
        stroke(tracker, 1.0, (0.0, 0.0, 0.0))
        first = tracker.path()
        end(tracker)
        ended = tracker.path()
        assert first is not None
        assert ended is not None
        stroke(tracker, 6.0, (0.0, 0.004, 0.0))
        second = tracker.path()
        assert second is not None
        assert second.print_id != first.print_id


@pytest.mark.parametrize('when', ['while it runs', 'in the pause'])
def test_a_recorded_print_begins_and_ends_where_it_was_told_to(when: str) -> None:
    live, again = PrintTracker(PAUSE), PrintTracker(PAUSE)
    told = {'while it runs': 2.0, 'in the pause': 3.6}[when]
    for tracker in (live, again):
        stroke(tracker, 1.0, (0.0, 0.0, 0.0), 0.01 if when == 'while it runs' else 0.02)
    live.stop(at_ns(told))
    stopped = live.path()
    assert stopped is not None
    again.follow(replace(stopped, finished=True))
    live.start(at_ns(4.0))
    begun = live.path()
    assert begun is not None
    again.follow(begun)
    for tracker in (live, again):
        stroke(tracker, 5.0, (0.0, 0.004, 0.0))
    one, other = live.path(), again.path()
    assert one is not None
    assert other is not None
    assert other.start_ns == at_ns(4.0)
    assert path_bytes(other) == path_bytes(one)


def test_a_recorded_print_that_was_cleared_is_gone() -> None:
    live, again = PrintTracker(PAUSE), PrintTracker(PAUSE)
    for tracker in (live, again):
        stroke(tracker, 1.0, (0.0, 0.0, 0.0))
    live.clear()
    again.follow(GrowingPath('', at_ns(4.0)).path())
    assert again.path() is None
    for tracker in (live, again):
        stroke(tracker, 5.0, (0.0, 0.004, 0.0))
    one, other = live.path(), again.path()
    assert one is not None
    assert other is not None
    assert path_bytes(other) == path_bytes(one)


def test_a_recorded_print_that_began_by_itself_tells_nothing() -> None:
    live, again = PrintTracker(PathConfig(auto_stop_after=0.5)), PrintTracker(PAUSE)
    for tracker in (live, again):
        stroke(tracker, 1.0, (0.0, 0.0, 0.0))
        stroke(tracker, 9.0, (0.0, 0.05, 0.0))  # away: another print
        path = tracker.path()
        assert path is not None
        assert path.start_ns == at_ns(9.0)
    before = again.path()
    path = live.path()
    assert path is not None
    again.follow(path)
    after = again.path()
    assert before is not None
    assert after is not None
    assert path_bytes(after) == path_bytes(before)


def test_what_was_laid_before_a_pause_stays_as_it_was() -> None:
    tracker = PrintTracker(PAUSE)
    stroke(tracker, 1.0, (0.0, 0.0, 0.0))
    times = np.arange(300, 500) / 100
    feed(tracker, times, np.tile((0.02, 0.0, 0.01), (200, 1)), [
        state(time, False) for time in times[::10]])
    before = tracker.path()
    assert before is not None
    assert before.finished
    stroke(tracker, 20.0, (0.0, 0.004, 0.0))
    after = tracker.path()
    assert after is not None
    assert not after.finished
    for name in ('time', 'arc_length', 'points', 'extruding'):
        np.testing.assert_array_equal(getattr(after, name)[:len(before)], getattr(before, name))
    new = after.where(np.arange(len(after)) >= len(before))
    assert new.time[0] == pytest.approx(19.0, abs=0.02)
    np.testing.assert_allclose(new.points[0], (0.0, 0.004, 0.0), atol=2e-4)


@pytest.mark.parametrize('lag', [-0.3, 0.3])
def test_a_print_goes_on_alike_whichever_topic_is_ahead(lag: float) -> None:
    def run(lag: float) -> DepositionPath:
        tracker = PrintTracker(PAUSE)
        times = np.arange(0, 20, 0.01)
        inked = ((times > 1) & (times < 3)) | (times > 15)
        x = np.cumsum(np.where(inked, 1e-4, 0.0))
        y = np.where(times > 10, 0.003, 0.0)
        events: list[Event] = [
            (time + lag, 0, (at_ns(time), np.array(tip)))
            for time, *tip in zip(times, x % 0.02, y, 0 * y, strict=True)]
        events += [(time, 1, state(time, bool(on)))
                   for time, on in list(zip(times, inked, strict=True))[::2]]
        return path_from(tracker, events)

    in_step, apart = run(0.0), run(lag)
    assert in_step.print_id == apart.print_id
    both = min(in_step.complete_until, apart.complete_until)
    one, other = (path.where(path.time <= both) for path in (in_step, apart))
    assert (one.time > 13).any()
    np.testing.assert_array_equal(one.points, other.points)


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
            tracker.add_pose(at_ns(number / 100), np.array((1e-4 * number, away, 0.0)))
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


# Prints that are resumed


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
    tracker.resume(path, at_ns(2.0 + away))
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
    tracker.resume(path, at_ns(2.0))
    printed(tracker, 1.0, 4.0)  # the last second once more
    after = tracker.path()
    assert after is not None
    assert (np.diff(after.time) > 0).all()
    np.testing.assert_allclose(after.arc_length, after.points[:, 0], atol=1e-9)


def test_a_print_left_off_is_complete_as_far_as_it_was() -> None:
    path, before = left_off()
    tracker = PrintTracker(PathConfig())
    tracker.resume(path, at_ns(2.0))
    for path_now in (tracker.path(), tracker.path()):
        assert path_now is not None
        assert path_now.complete_until == before.complete_until


def test_a_print_left_off_still_ends_by_itself() -> None:
    path, _ = left_off()
    tracker = PrintTracker(PathConfig(auto_stop_after=1.0))
    tracker.resume(path, at_ns(5.0))
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
        tracker.add_pose(at_ns(number / 100), np.zeros(3))
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
    assert after.start_ns == at_ns(3600.0)
    assert after.time[0] < 0.1


def test_a_robot_at_1000_hz_fills_no_memory() -> None:
    """Beside the path, only what smoothing and the start of a print need is kept."""
    tracker = PrintTracker(PathConfig())
    for number in range(30_000):
        if number % 20 == 0:
            tracker.add_extruder(state(number / 1000))
            path = tracker.growing_path()
        tracker.add_pose(at_ns(number / 1000), np.array((3e-6 * number, 0.0, 0.0)))
    assert path is not None
    made = tracker._print
    assert made is not None
    assert len(path) == pytest.approx(0.09 / 2e-4, abs=3)
    assert len(tracker._poses) <= 5001  # of the last 5 s
    assert len(tracker._states) <= 251
    smoother, resampler, joined = made._smoother, made._resampler, made._joiner
    assert max(len(smoother._new), len(smoother._poses), len(resampler._poses)) < 300
    assert max(len(joined._points), len(joined._states)) < 30
