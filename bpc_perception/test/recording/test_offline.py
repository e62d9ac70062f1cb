"""A recording measured without a graph, with all that may be in it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Set
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from perception_builders import (
    at_ns,
    band_image,
    capture_of,
    DOWN,
    pose,
    SECOND,
    surface,
)
import pytest

from bpc_perception.core.config import AdviceConfig, PathConfig, RecorderConfig, ThicknessConfig
from bpc_perception.core.path.print_id import print_id_of
from bpc_perception.core.result import Result
from bpc_perception.core.robot.hand_eye import HandEye

pytest.importorskip('rclpy')
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Header

from bpc_interfaces.msg import DepositionPath, ExtrusionState
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.poses.pose import pose_to_message
from bpc_perception.messages.stamps import ns_to_stamp, stamp_to_ns
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.offline import measure_bag

pytestmark = pytest.mark.ros
Entry = tuple[str, int, Any]
CONFIG = ThicknessConfig(method='paper', patience=2.0,
                         advice=AdviceConfig(target_thickness=2.2e-3))
RECORDER = RecorderConfig(path=PathConfig(auto_stop_after=3.0))
START, SPEED = surface(np.array((40.0, 55.0))), 4e-3  # 3.2 s over the band
CAPTURES = np.arange(0.5, 3.6, 1.0)


class Recorded(Bag):
    """A recording of these messages that notes how far it was read."""

    def __init__(self, entries: Iterable[Entry]) -> None:
        self.path, self.others = Path('recorded'), {}
        self.entries = list(entries)
        self.topics = {name: topics.type_name(kind) for name, kind in {
            **topics.CAMERA, topics.POSE: PoseStamped, topics.EXTRUSION: ExtrusionState}.items()}
        self.read_ns = 0

    def messages(self, topics: set[str],
                 light: bool = False) -> Iterator[Entry]:  # noqa: ARG002 (see Bag)
        for name, log_ns, message in self.entries:
            self.read_ns = log_ns
            if name in topics:
                yield name, log_ns, message

    def count(self, topic: str) -> int:
        return sum(name == topic for name, _, _ in self.entries)


def robot(time: float, stamped: float | None = None) -> Iterable[Entry]:
    """The tip moves along the band for 3.2 s, and then stands."""
    tip = START + np.array((SPEED * min(time, 3.2), 0, 0))
    stamp_ns = at_ns(time if stamped is None else stamped)
    yield topics.POSE, at_ns(time), pose_to_message(stamp_ns, '', pose(tip))


def extruder(time: float, stamped: float | None = None) -> Iterable[Entry]:
    state = ExtrusionState(extruding=time <= 3.2, plunger_velocity=1e-4, flow_rate=5e-8)
    state.header.stamp = ns_to_stamp(at_ns(time if stamped is None else stamped))
    yield topics.EXTRUSION, at_ns(time), state


def camera(time: float, stamped: float | None = None) -> Iterable[Entry]:
    capture = capture_of(band_image(), at_ns(time if stamped is None else stamped))
    for name, message in zip(topics.CAMERA, capture_to_messages(capture), strict=True):
        yield name, at_ns(time), message


def recorded(poses_until: float = 4.0, captures: Iterable[float] = CAPTURES) -> list[Entry]:
    """Return the messages of a print in the order of recording."""
    entries = [entry for number in range(400) for entry in (
        *(robot(number / 100) if number / 100 < poses_until else ()), *extruder(number / 100))]
    entries += [entry for time in captures for entry in camera(time)]
    return sorted(entries, key=lambda entry: entry[1])


def measured(bag: Bag) -> Iterator[Result]:
    return measure_bag(bag, HandEye(True, DOWN), CONFIG, RECORDER)


def told(results: Iterable[Result]) -> list[str]:
    """Return all results, to the last bit."""
    return [repr((result.capture.stamp_ns, result.advice, result.refusal,
                  result.profile and result.profile.thickness.tobytes())) for result in results]


@pytest.fixture(scope='module')
def expected() -> list[str]:
    """Return the results of the print as it should be recorded."""
    found = told(measured(Recorded(recorded())))
    assert len(found) == len(CAPTURES)
    assert not any(': expected' in each for each in found)
    return found


LOG_TIMES: dict[str, Callable[[int], int]] = {
    'another clock': lambda log_ns: log_ns - 3600 * SECOND,
    'a clock ahead': lambda log_ns: log_ns + 3600 * SECOND,
    'a clock set forward': lambda log_ns: log_ns + 3600 * SECOND * (log_ns > at_ns(1.505)),
    'a clock set back': lambda log_ns: log_ns - 3600 * SECOND * (log_ns > at_ns(1.505)),
    'none': lambda _: 0}


def test_captures_that_the_path_never_reaches_do_not_pile_up() -> None:
    bag = Recorded(recorded(poses_until=1.0, captures=np.arange(0.5, 10, 0.5)))
    for result in measured(bag):
        assert bag.read_ns - result.capture.stamp_ns <= 3 * SECOND  # patience and one capture


@pytest.mark.parametrize('clock', LOG_TIMES)
def test_by_whatever_clock_it_was_recorded_a_print_is_measured(
        clock: str, expected: list[str], caplog: pytest.LogCaptureFixture) -> None:
    entries = [(name, LOG_TIMES[clock](log_ns), message) for name, log_ns, message in recorded()]
    assert told(measured(Recorded(entries))) == expected
    assert caplog.text == ''


@pytest.mark.parametrize('when', [0.0, 1.0])  # at the start, and in between
@pytest.mark.parametrize('source', [robot, extruder, camera])
def test_messages_of_the_future_spoil_no_recording(
        source: Callable[[float, float], Iterable[Entry]], when: float,
        expected: list[str], caplog: pytest.LogCaptureFixture) -> None:
    entries = recorded()
    index = next(index for index, (_, log_ns, _) in enumerate(entries) if log_ns >= at_ns(when))
    entries[index:index] = source(when, when + 60)
    assert told(measured(Recorded(entries))) == expected
    assert 'expected a stamp of the past, found one 60.' in caplog.text
    assert 'behind' not in caplog.text


def stamped_off(names: Set[str], off: float) -> list[Entry]:
    """The print, with the stamps of some topics off by a time [s]."""
    entries = []
    for name, log_ns, message in recorded():
        if name in names:  # each has a header of its own, but for those of a capture
            message.header = Header(frame_id=message.header.frame_id, stamp=ns_to_stamp(
                stamp_to_ns(message.header.stamp) + round(off * SECOND)))
        entries.append((name, log_ns, message))
    return entries


@pytest.mark.parametrize('names', [{topics.POSE}, {topics.EXTRUSION}])
@pytest.mark.parametrize('recorder', [0, -3600])
def test_a_topic_whose_clock_is_ahead_is_left_out_as_live(
        names: Set[str], recorder: int, caplog: pytest.LogCaptureFixture) -> None:
    entries = [(name, log_ns + recorder * SECOND, message)
               for name, log_ns, message in stamped_off(names, 0.5)]
    assert all(result.profile is None for result in measured(Recorded(entries)))
    lines = caplog.text.splitlines()
    assert sum('found one 0.50 s in the future by the clock of the others' in line
               for line in lines) == 1


@pytest.mark.parametrize(('names', 'off'), [
    ({topics.POSE}, -0.5), ({topics.EXTRUSION}, -1.0), (set(topics.CAMERA), -2.5)])
def test_a_topic_whose_clock_is_behind_is_named(names: Set[str], off: float,
                                                caplog: pytest.LogCaptureFixture) -> None:
    found = list(measured(Recorded(stamped_off(names, off))))
    for name in names:
        assert f'{name}: expected stamps by the clock of the others' in caplog.text
    # What is of another moment is not used; a camera may take long.
    assert names == set(topics.CAMERA) or all(result.profile is None for result in found)


@pytest.mark.parametrize('every', [100, 200])
def test_states_that_come_seldom_are_warned_of(every: int,
                                               caplog: pytest.LogCaptureFixture) -> None:
    states = (index for index, (name, _, _) in enumerate(recorded()) if name == topics.EXTRUSION)
    kept = set(islice(states, 0, None, every))
    list(measured(Recorded(entry for index, entry in enumerate(recorded())
                           if entry[0] != topics.EXTRUSION or index in kept)))
    assert f'too far apart, {every / 100:.1f} s' in caplog.text


@pytest.mark.parametrize('source', [robot, extruder])
def test_what_comes_late_into_a_recording_is_said_once(
        source: Callable[[float], Iterable[Entry]], expected: list[str],
        caplog: pytest.LogCaptureFixture) -> None:
    entries = recorded()
    entries[300:300] = [*source(0.5), *source(0.6)]
    assert told(measured(Recorded(entries))) == expected
    assert caplog.text.count('found some late, twice or a jump') == 1


def test_of_the_recording_of_a_print_no_other_is_measured() -> None:
    """What came shortly before the start has ink of the print before."""
    begun = DepositionPath(print_id=print_id_of(at_ns(1.205)))
    begun.header.stamp = ns_to_stamp(at_ns(1.205))
    bag = Recorded(sorted([*recorded(), (topics.PATH, at_ns(1.25), begun)],
                          key=lambda entry: entry[1]))
    bag.topics[topics.PATH] = topics.type_name(DepositionPath)

    def found(print_id: str) -> list[tuple[str, bool]]:
        results = measure_bag(bag, HandEye(True, DOWN), CONFIG, RECORDER, print_id)
        return [(result.profile.print_id if result.profile else '', bool(result.refusal))
                for result in results]

    own, before = begun.print_id, print_id_of(at_ns(0.0))
    assert found(own) == [('', True), (own, False), (own, False), (own, False)]
    assert found('') == [(before, False), (own, False), (own, False), (own, False)]
    assert found('of which it has no path') == found('')
