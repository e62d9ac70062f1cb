"""Each node in process: messages in, messages out, and never a crash."""

from __future__ import annotations

from array import array
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from functools import partial
import os
from pathlib import Path
import re
import select
import signal
import subprocess
import sys
from threading import Event
import time
from typing import Any

import numpy as np
from perception_builders import (
    band_image,
    capture_of,
    DOWN,
    PIXEL,
    pixel_path,
    pose,
    SECOND,
    START_NS,
)
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.parameter import ConfigError, parameters_of
from bpc_perception.core.path.growing_path import GrowingPath

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

from bpc_interfaces.msg import (
    DepositionPathUpdate,
    ExtrusionState,
    RateAdvice,
    ThicknessProfile,
)
from bpc_perception.drivers.bag import BagCamera
from bpc_perception.files.hand_eye_file import HandEyeError
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_from_messages, capture_to_messages
from bpc_perception.messages.path import path_from_message, path_to_message, path_to_nav
from bpc_perception.messages.pose import pose_to_message
from bpc_perception.messages.stamps import ns_to_stamp, stamp_to_ns
from bpc_perception.nodes.camera_driver import CameraDriverNode
from bpc_perception.nodes.parts.path_follower import PathFollower
from bpc_perception.nodes.path_recorder import PathRecorderNode
from bpc_perception.nodes.thickness import ThicknessNode
from bpc_perception.recording.bag import Bag, BagError
from bpc_perception.recording.bag_writer import BagWriter
from bpc_perception.recording.path_journal import PathJournal
from bpc_perception.runtime.transport.dds_profiles import with_profile

pytestmark = pytest.mark.ros
BASE = 'lbr_link_0'
INPUTS = {**topics.CAMERA, **topics.PRINT, topics.PATH: topics.RESULTS[topics.PATH]}
QOS = {**dict.fromkeys(topics.CAMERA, topics.CAMERA_QOS), topics.POSE: topics.POSE_QOS,
       topics.EXTRUSION: topics.EXTRUSION_QOS, topics.PATH: topics.PATH_QOS}
METHODS = parameters_of(ThicknessConfig)['method'][0].choices


class Bench:
    """A node under test, and one that talks to it and listens."""

    def __init__(self, graph: Any, kind: Any, **parameters: Any) -> None:
        self.graph = graph
        self.node = graph.make(kind, **parameters)
        self.peer: Node = graph.make(Node, 'peer')
        self.received: dict[str, list[Any]] = defaultdict(list)
        self._publishers: dict[str, Any] = {}
        self.listen('/diagnostics', DiagnosticArray, QoSProfile(depth=100))
        # By itself it publishes once a second only, which most tests here would wait for.
        self.timer = self.peer.create_timer(0.1, self.node._diagnostics.publish)

    def until(self, condition: Callable[[], Any], timeout: float = 10.0) -> None:
        self.graph.spin_until(condition, timeout)

    def listen(self, topic: str, kind: Any, qos: QoSProfile) -> list[Any]:
        """The messages that arrive on a topic from now on."""
        received = self.received[topic]
        self.peer.create_subscription(kind, topic, received.append, qos)
        self.until(lambda: self.peer.count_publishers(topic))
        return received

    def send(self, topic: str, *messages: Any, kind: Any = None, qos: Any = None) -> None:
        """Publish, as soon as the node listens."""
        if topic not in self._publishers:
            self._publishers[topic] = self.peer.create_publisher(
                kind or INPUTS[topic], topic, qos or QOS[topic])
        publisher = self._publishers[topic]
        self.until(publisher.get_subscription_count)
        for message in messages:
            publisher.publish(message)

    def send_capture(self, stamp_ns: int,
                     spoil: Callable[[dict[str, Any]], None] | None = None) -> None:
        messages = dict(zip(topics.CAMERA, capture_to_messages(
            capture_of(band_image(), stamp_ns)), strict=True))
        if spoil:
            spoil(messages)
        for name, message in messages.items():
            self.send(name, message)

    def call(self, service: str) -> Trigger.Response:
        client = self.peer.create_client(Trigger, service)
        self.until(client.service_is_ready)
        future = client.call_async(Trigger.Request())
        self.until(future.done)
        return future.result()

    @property
    def statuses(self) -> list[Any]:
        return [status for message in self.received['/diagnostics'] for status in message.status
                if status.name == self.node.get_name()]

    def diagnosed(self, key: str) -> str:
        """The latest value of a diagnostic; empty = none."""
        values = {value.key: value.value for value in self.statuses[-1].values} \
            if self.statuses else {}
        return str(values.get(key, ''))


# The path recorder

T_BASE_FLANGE = np.diag((1.0, -1.0, -1.0, 1.0))  # the tool points down
T_BASE_FLANGE[2, 3] = 0.15
NOZZLE = [0.0, 0.0, 0.15]


def flange_pose(time: float, speed: float = 0.01, start_ns: int = START_NS) -> PoseStamped:
    """The flange at a time [s], while the nozzle moves along the x axis."""
    T = T_BASE_FLANGE.copy()
    T[0, 3] = speed * time
    return pose_to_message(start_ns + round(time * SECOND), BASE, T)


def extrusion(time: float, extruding: bool = True, start_ns: int = START_NS) -> ExtrusionState:
    message = ExtrusionState(extruding=extruding, plunger_velocity=1e-4, flow_rate=5e-8)
    message.header.stamp = ns_to_stamp(start_ns + round(time * SECOND))
    return message


def recorder(graph: Any, **parameters: Any) -> Bench:
    return Bench(graph, PathRecorderNode, nozzle_offset=NOZZLE, publish_rate=50.0, **parameters)


def print_line(bench: Bench, start_ns: int = START_NS) -> list[Any]:
    """Three seconds of a print; the paths that come out."""
    paths = bench.listen(topics.PATH, topics.RESULTS[topics.PATH], topics.PATH_QOS)
    bench.send(topics.EXTRUSION, *(extrusion(t, start_ns=start_ns)
                                   for t in np.arange(0, 3, 0.1)))
    bench.until(lambda: paths)  # the print has begun
    for times, known in ((np.arange(0, 1.5, 0.05), 1.3), (np.arange(1.5, 3, 0.05), 2.8)):
        bench.send(topics.POSE, *(flange_pose(t, start_ns=start_ns) for t in times))
        bench.until(lambda reached=known: paths[-1].complete_until > reached)
    return paths


def test_poses_and_extruder_states_become_the_path_of_the_nozzle(graph: Any) -> None:
    message = print_line(recorder(graph))[-1]
    assert message.header.frame_id == BASE
    assert stamp_to_ns(message.header.stamp) == START_NS
    path = path_from_message(message)
    assert len(path) > 100
    np.testing.assert_allclose(path.points[:, 0], 0.01 * path.time, atol=1e-9)
    np.testing.assert_allclose(path.points[:, 1:], 0, atol=1e-12)
    assert path.extruding.all()
    np.testing.assert_allclose(path.flow_rate, 5e-8)


def test_a_late_subscriber_still_gets_the_path(graph: Any) -> None:
    bench = recorder(graph)
    known = print_line(bench)[-1]
    late: list[Any] = []
    graph.make(Node, 'late').create_subscription(
        topics.RESULTS[topics.PATH], topics.PATH, late.append, topics.PATH_QOS)
    bench.until(lambda: late)
    assert late[-1] == known


def test_updates_make_up_the_path(graph: Any) -> None:
    bench = recorder(graph)
    updates = bench.listen(topics.PATH_UPDATE, DepositionPathUpdate, topics.PATH_UPDATE_QOS)
    whole = path_from_message(print_line(bench)[-1])
    growing = GrowingPath(whole.print_id, whole.start_ns)
    bench.until(lambda: updates[-1].path.complete_until == whole.complete_until)
    assert updates[0].first == 0
    assert max(len(update.path.x) for update in updates) < len(whole)
    assert all(growing.extend(update.first, path_from_message(update.path))
               for update in updates)
    np.testing.assert_array_equal(growing.path().points, whole.points)


def test_viewers_get_the_path_too(graph: Any) -> None:
    bench = recorder(graph)
    viewed = bench.listen(topics.NAV_PATH, topics.RESULTS[topics.NAV_PATH], topics.PATH_QOS)
    message = print_line(bench)[-1]
    bench.until(lambda: viewed and len(viewed[-1].poses) == len(message.x))
    assert viewed[-1] == path_to_nav(path_from_message(message), BASE)


def test_start_and_stop_by_service(graph: Any) -> None:
    bench = recorder(graph, path__auto=False, watch__maximum_lead=60.0)
    paths = bench.listen(topics.PATH, topics.RESULTS[topics.PATH], topics.PATH_QOS)
    assert not bench.call('path_recorder/stop').success
    started = bench.call('path_recorder/start')
    assert started.success
    bench.until(lambda: paths)
    start_ns = stamp_to_ns(paths[-1].header.stamp)
    assert paths[-1].print_id == started.message
    bench.send(topics.POSE, *(flange_pose(t, start_ns=start_ns) for t in np.arange(0, 3, 0.05)))
    bench.until(lambda: len(paths[-1].x) > 50)
    assert not paths[-1].finished
    assert bench.call('path_recorder/stop').success
    bench.send(topics.POSE, *(flange_pose(t, start_ns=start_ns)
                              for t in np.arange(30, 31, 0.05)))
    bench.until(lambda: paths[-1].finished)
    assert paths[-1].print_id == started.message


def test_a_print_is_saved_and_cleared(graph: Any, tmp_path: Path) -> None:
    bench = recorder(graph, output_folder=str(tmp_path))
    nothing = bench.call('path_recorder/save')
    assert (nothing.success, nothing.message) == (False, 'expected a print, found none started')
    message = print_line(bench)[-1]
    saved = bench.call('path_recorder/save')
    assert saved.success
    assert Path(saved.message).parent == tmp_path
    (_, _, stored), = Bag(saved.message).messages({'/deposition_path'})
    assert stored == message
    again = bench.call('path_recorder/save')
    assert not again.success
    assert 'expected a new bag' in again.message
    assert bench.call('path_recorder/clear').success
    assert not bench.call('path_recorder/save').success


def test_unusable_poses_and_states_are_counted(graph: Any) -> None:
    bench = recorder(graph, watch__warn_after=0.0)  # what comes once falls silent
    wrong_frame, not_a_number, good = flange_pose(0.2), flange_pose(0.3), flange_pose(0.4)
    wrong_frame.header.frame_id = 'world'
    not_a_number.pose.position.y = np.nan
    bench.send(topics.POSE, flange_pose(0.1), wrong_frame, not_a_number, flange_pose(0.1), good)
    bench.send(topics.EXTRUSION, extrusion(0.2, False), extrusion(0.1, False))
    bench.until(lambda: bench.diagnosed('refused: extrusion_state') == '1'
                and bench.diagnosed('poses') == '2')
    assert bench.diagnosed('refused: pose') == '3'
    assert bench.diagnosed('extrusion states') == '1'
    assert 'expected' in bench.diagnosed('last refusal')
    assert DiagnosticStatus.WARN in [status.level for status in bench.statuses]
    # What is over is no warning any more, but stays counted.
    bench.until(lambda: bench.statuses[-1].level == DiagnosticStatus.OK)
    assert bench.diagnosed('refused: pose') == '3'


FUTURE_NS = (2**31 - 60) * SECOND  # as far as messages reach


def test_poses_and_states_of_the_future_do_not_keep_out_those_that_follow(graph: Any) -> None:
    bench = recorder(graph, watch__warn_after=0.0)
    bench.send(topics.POSE, flange_pose(0, start_ns=FUTURE_NS), flange_pose(0.1))
    bench.send(topics.EXTRUSION, extrusion(0, False, FUTURE_NS), extrusion(0.1, False))
    bench.until(lambda: bench.diagnosed('poses') == '1'
                and bench.diagnosed('extrusion states') == '1')
    assert bench.diagnosed('refused: pose') == '1'
    assert bench.diagnosed('refused: extrusion_state') == '1'
    assert 'found one of the future' in bench.diagnosed('last refusal')


def test_an_extruder_in_error_is_warned_of(graph: Any) -> None:
    bench = recorder(graph, watch__warn_after=0.0)
    state = extrusion(0.1)
    state.error_status = 1 << 6
    bench.send(topics.EXTRUSION, state)
    bench.until(lambda: bench.diagnosed('last warning').endswith('found error_status 64'))
    assert bench.diagnosed('extrusion states') == '1'
    assert DiagnosticStatus.WARN in [status.level for status in bench.statuses]


def test_poses_that_jump_are_counted(graph: Any) -> None:
    bench = recorder(graph, watch__warn_after=0.0)
    bench.send(topics.POSE, flange_pose(0.1), flange_pose(0.11, speed=10.0), flange_pose(0.12))
    bench.until(lambda: bench.diagnosed('poses') == '2')
    assert bench.diagnosed('refused: pose') == '1'
    assert bench.diagnosed('last refusal').endswith('found a jump')


def test_a_recorder_started_again_goes_on_with_its_print(graph: Any, tmp_path: Path) -> None:
    """Those who follow the path have the same points as the recorder, before and after."""
    first = recorder(graph, state_folder=str(tmp_path))
    followed: list[Any] = []
    PathFollower(first.peer, BASE, followed.append, followed.append)
    before = path_from_message(print_line(first)[-1])
    first.timer.cancel()
    graph.executor.remove_node(first.node)
    # As after a kill: it says nothing any more, and the file is as it was.
    first.node.destroy_node()
    graph._nodes.remove(first.node)
    again = recorder(graph, state_folder=str(tmp_path))
    paths = again.listen(topics.PATH, topics.RESULTS[topics.PATH], topics.PATH_QOS)
    again.until(lambda: paths)
    assert path_from_message(paths[-1]).print_id == before.print_id
    again.until(lambda: 'is resumed' in again.diagnosed('last warning'))
    again.send(topics.EXTRUSION, *(extrusion(t) for t in np.arange(6, 9, 0.1)))
    again.send(topics.POSE, *(flange_pose(t) for t in np.arange(6, 9, 0.05)))
    again.until(lambda: paths[-1].complete_until > 8.5
                and followed[-1].complete_until == paths[-1].complete_until)
    after = path_from_message(paths[-1])
    assert (after.print_id, after.start_ns) == (before.print_id, before.start_ns)
    np.testing.assert_array_equal(after.points[:len(before)], before.points)
    np.testing.assert_array_equal(followed[-1].points, after.points)
    gap = np.flatnonzero(np.diff(after.time) > 1.0)
    assert len(gap) == 1
    assert after.time[gap[0]] < 3.0 < 5.9 < after.time[gap[0] + 1]


def test_a_folder_that_cannot_be_written_to_costs_no_print(graph: Any, tmp_path: Path) -> None:
    (tmp_path / 'file').touch()
    bench = recorder(graph, state_folder=str(tmp_path / 'file'))
    assert len(print_line(bench)[-1].x) > 100
    assert bench.diagnosed('refused: state_folder') == '1'


def test_a_print_left_off_with_another_nozzle_is_not_gone_on_with(graph: Any,
                                                                  tmp_path: Path) -> None:
    config = RecorderConfig(nozzle_offset=(0.0, 0.0, 0.1))
    path = GrowingPath('left_off', START_NS)
    path.extend(0, replace(pixel_path((0, 0), (9, 0)), print_id='left_off', finished=False))
    journal = PathJournal(tmp_path, config)
    journal.take(path, time.time_ns())
    journal.close()
    bench = recorder(graph, state_folder=str(tmp_path))
    bench.until(lambda: 'nozzle_offset' in bench.diagnosed('last warning'))
    assert path_from_message(print_line(bench)[-1]).print_id != 'left_off'


def test_a_journal_that_cannot_be_used_costs_neither_print_nor_service(graph: Any,
                                                                       tmp_path: Path) -> None:
    (tmp_path / 'running_print.mcap' / 'folder.mcap').mkdir(parents=True)  # where files should be
    bench = recorder(graph, state_folder=str(tmp_path))
    bench.until(lambda: bench.diagnosed('refused: journal') == '1')  # to be read
    assert len(print_line(bench)[-1].x) > 100
    bench.until(lambda: bench.diagnosed('refused: journal') == '2')  # to be written
    assert bench.call('path_recorder/clear').success
    bench.until(lambda: bench.diagnosed('refused: journal') == '3')  # to be removed


def test_a_full_disk_costs_no_print(graph: Any, tmp_path: Path) -> None:
    (tmp_path / 'running_print.tmp').symlink_to('/dev/full')
    bench = recorder(graph, state_folder=str(tmp_path))
    assert len(print_line(bench)[-1].x) > 100
    bench.until(lambda: bench.diagnosed('refused: journal') == '1')
    assert 'No space left on device' in bench.diagnosed('last refusal')


def test_silence_of_an_input_is_said_at_once_and_until_it_is_over(graph: Any) -> None:
    """Not with the next of the diagnostics that come each second."""
    bench = recorder(graph, watch__warn_after=0.2, watch__error_after=0.4)
    bench.timer.cancel()
    states = bench.received['/diagnostics']
    bench.until(lambda: states and states[-1].status[0].level == DiagnosticStatus.STALE)
    for number in range(20):
        bench.send(topics.POSE, flange_pose(0.1 * number))
        bench.send(topics.EXTRUSION, extrusion(0.1 * number, False))
    bench.until(lambda: states[-1].status[0].level == DiagnosticStatus.ERROR)
    levels = [state.status[0].level for state in states]
    ok, warn, error = (len(levels) - 1 - levels[::-1].index(level) for level in (
        DiagnosticStatus.STALE, DiagnosticStatus.WARN, DiagnosticStatus.ERROR))
    assert ok < warn < error == len(levels) - 1
    published = [state.header.stamp.sec + state.header.stamp.nanosec * 1e-9
                 for state in states[warn:]]
    assert published[-1] - published[0] < 0.9  # a period of the diagnostics is 1 s
    assert 'found lasting silence' in states[-1].status[0].message
    sent = 20

    def heard_again() -> bool:
        nonlocal sent
        sent += 1
        bench.send(topics.POSE, flange_pose(0.1 * sent))
        bench.send(topics.EXTRUSION, extrusion(0.1 * sent, False))
        return bool(states[-1].status[0].level == DiagnosticStatus.OK)

    bench.until(heard_again)


def test_a_second_fault_is_said_as_soon_as_the_first(graph: Any) -> None:
    """Also within the second of the diagnostics in which the first was said."""
    bench = recorder(graph, watch__warn_after=0.2, watch__error_after=60.0)
    bench.timer.cancel()
    states = bench.received['/diagnostics']
    sent = 0

    def goes_on(*names: str) -> None:
        nonlocal sent
        sent += 1
        if topics.POSE in names:
            bench.send(topics.POSE, flange_pose(0.02 * sent))
        if topics.EXTRUSION in names:
            bench.send(topics.EXTRUSION, extrusion(0.02 * sent, False))

    def said(text: str, *names: str) -> float:
        """When it was said first, if these inputs go on [s]."""
        before = len(states)

        def those() -> list[Any]:
            goes_on(*names)
            return [state for state in states[before:] if text in state.status[0].message]

        bench.until(those)
        return stamp_to_ns(those()[0].header.stamp) * 1e-9

    said('ok', topics.POSE, topics.EXTRUSION)
    silence = 'expected messages, found silence'
    first = said(f'{topics.EXTRUSION}: {silence}', topics.POSE)
    second = said(f'{topics.EXTRUSION}, {topics.POSE}: {silence}')  # the first goes on
    assert second - first < 0.8
    over = said('ok', topics.POSE, topics.EXTRUSION)
    assert over - second < 0.8
    bench.node._diagnostics.refuse('one: of a kind')
    bench.node._diagnostics.refuse('another: of a kind')
    refused = said('one: of a kind; another: of a kind', topics.POSE, topics.EXTRUSION)
    bench.node._diagnostics.refuse('new: of a kind')
    assert said('new: of a kind', topics.POSE, topics.EXTRUSION) - refused < 0.8
    bench.node._diagnostics.refuse('new: the same again')  # as often as messages come
    assert said('new: the same again', topics.POSE, topics.EXTRUSION) - refused > 0.9


def test_a_clock_that_goes_back_clears_the_print(graph: Any) -> None:
    bench = recorder(graph, use_sim_time=True)

    def set_clock(seconds: int) -> None:
        bench.send('/clock', Clock(clock=ns_to_stamp(seconds * SECOND)), kind=Clock, qos=10)
        bench.until(lambda: bench.node.get_clock().now().nanoseconds == seconds * SECOND)

    set_clock(100)
    print_line(bench, start_ns=100 * SECOND)
    set_clock(101)
    assert bench.call('path_recorder/stop').success  # a print was running
    set_clock(50)
    assert bench.call('path_recorder/save').message == 'expected a print, found none started'
    # Earlier stamps are taken again.
    paths = bench.received[topics.PATH]
    bench.send(topics.EXTRUSION, extrusion(0, start_ns=50 * SECOND))
    bench.until(lambda: stamp_to_ns(paths[-1].header.stamp) == 50 * SECOND)


# The thickness node

CALIBRATION = """\
parameters: {{calibration_type: {mount}}}
transform:
  translation: {{x: 0.0, y: 0.0, z: 0.5}}
  rotation: {{x: 1.0, y: 0.0, z: 0.0, w: 0.0}}
"""
STAMP = START_NS + 10 * SECOND
WIDTH_TRUE = 11 * PIXEL
PATH = path_to_message(pixel_path((40, 55), (120, 55), 81), BASE)


def thickness(graph: Any, folder: Path, mount: str = 'eye_on_base', **parameters: Any) -> Bench:
    file = folder / 'camera.calib'
    file.write_text(CALIBRATION.format(mount=mount))
    bench = Bench(graph, ThicknessNode, hand_eye_file=str(file), **parameters)
    bench.listen(topics.PROFILE, ThicknessProfile, topics.RESULT_QOS)
    bench.listen(topics.ADVICE, RateAdvice, topics.RESULT_QOS)
    return bench


def assert_profile_comes(bench: Bench, stamp_ns: int) -> ThicknessProfile:
    """It comes, it is right, and it is the only one."""
    profiles = bench.received[topics.PROFILE]
    bench.until(lambda: profiles and bench.received[topics.ADVICE])
    profile, = profiles
    assert stamp_to_ns(profile.header.stamp) == stamp_ns
    np.testing.assert_allclose(profile.thickness, WIDTH_TRUE, atol=1.01 * PIXEL)
    return profile


@pytest.mark.parametrize('method', METHODS)
def test_capture_and_path_become_profile_and_advice(graph: Any, tmp_path: Path,
                                                    method: str) -> None:
    bench = thickness(graph, tmp_path, method=method, advice__target_thickness=WIDTH_TRUE,
                      advice__dead_band=0.12)
    bench.send(topics.PATH, PATH)
    bench.send_capture(STAMP)
    profile = assert_profile_comes(bench, STAMP)
    assert (profile.header.frame_id, profile.print_id, profile.method, profile.capture) == (
        BASE, 'print', method, 0)
    assert set(profile.status) == {ThicknessProfile.MEASURED}
    assert profile.thickness_median == pytest.approx(WIDTH_TRUE, abs=1.01 * PIXEL)
    advice = bench.received[topics.ADVICE][0]
    assert advice.valid
    assert advice.reason == RateAdvice.ON_TARGET
    assert advice.target_thickness == WIDTH_TRUE
    assert stamp_to_ns(advice.header.stamp) == STAMP


def test_a_capture_waits_for_the_path(graph: Any, tmp_path: Path) -> None:
    bench = thickness(graph, tmp_path)
    bench.send_capture(STAMP)
    bench.until(lambda: bench.diagnosed('captures') == '1')
    assert bench.received[topics.PROFILE] == []
    bench.send(topics.PATH, PATH)
    assert_profile_comes(bench, STAMP)


def test_a_capture_of_the_future_is_refused(graph: Any, tmp_path: Path) -> None:
    """What was laid by its stamp, but not yet when it was taken, would pass for gaps."""
    bench = thickness(graph, tmp_path)
    bench.send(topics.PATH, PATH)
    bench.send_capture(FUTURE_NS)
    bench.until(lambda: bench.diagnosed('refused: capture') == '1')
    assert 'found one of the future' in bench.diagnosed('last refusal')
    bench.send_capture(STAMP)
    assert_profile_comes(bench, STAMP)


def test_captures_that_stop_are_missed(graph: Any, tmp_path: Path) -> None:
    bench = thickness(graph, tmp_path)
    bench.timer.cancel()
    watch = bench.node._diagnostics._inputs['captures']
    bench.send_capture(STAMP)
    bench.until(lambda: watch.age(time.monotonic()) is not None)
    for age in (4, 3, 2, 1):  # as if one had come each second until now
        watch.heard(time.monotonic() - age)
    bench.until(lambda: any('captures: expected messages, found silence' in status.message
                            for status in bench.statuses))


def test_a_deposit_beside_its_path_is_warned_of(graph: Any, tmp_path: Path) -> None:
    bench = thickness(graph, tmp_path)
    bench.send(topics.PATH, path_to_message(pixel_path((40, 59), (120, 59), 81), BASE))
    bench.send_capture(STAMP)
    bench.until(lambda: any('offset: ' in status.message for status in bench.statuses))
    profile, = bench.received[topics.PROFILE]
    # The band's middle is at v = 55, and smaller v is to the left of travel along u.
    assert profile.offset_mean == pytest.approx(4 * PIXEL, abs=PIXEL / 2)
    assert profile.offset_rms == pytest.approx(4 * PIXEL, abs=PIXEL / 2)


def test_the_newest_of_captures_is_measured_and_the_others_are_counted(graph: Any,
                                                                       tmp_path: Path) -> None:
    bench = thickness(graph, tmp_path)
    bench.send(topics.PATH, PATH)
    bench.until(lambda: bench.node._session._path)
    turns = [bench.node.hand_over(capture_of(band_image(), STAMP + number * SECOND))
             for number in range(3)]
    assert not turns[0].is_set()
    assert_profile_comes(bench, STAMP + 2 * SECOND)
    assert all(turn.is_set() for turn in turns)
    bench.until(lambda: bench.diagnosed('captures skipped for newer ones') == '2')
    assert bench.diagnosed('captures') == '3'
    assert bench.statuses[-1].level == DiagnosticStatus.OK


def test_a_path_in_parts_is_as_good(graph: Any, tmp_path: Path) -> None:
    bench = thickness(graph, tmp_path)
    path = path_from_message(PATH)
    half = path.until(STAMP - 9 * SECOND - SECOND // 2)
    rest = path.where(np.arange(len(path)) >= len(half))
    assert len(half) > 10 < len(rest)
    bench.send_capture(STAMP)
    for first, part in ((0, replace(half, complete_until=0.5, finished=False)),
                        (len(half), rest)):
        bench.send(topics.PATH_UPDATE, DepositionPathUpdate(
            first=first, path=path_to_message(part, BASE)), kind=DepositionPathUpdate,
            qos=topics.PATH_UPDATE_QOS)
    assert len(assert_profile_comes(bench, STAMP).x) == len(path)


def test_who_looks_gets_markers_overlay_and_scalars(graph: Any, tmp_path: Path) -> None:
    bench = thickness(graph, tmp_path, advice__target_thickness=WIDTH_TRUE)
    views = [bench.listen(name, kind, topics.VIEW_QOS) for name, kind in topics.VIEWS.items()]
    bench.send(topics.PATH, PATH)
    bench.send_capture(STAMP)
    bench.until(lambda: all(views))
    width = bench.received[topics.WIDTH][0].data
    assert width == pytest.approx(WIDTH_TRUE, abs=PIXEL)


def test_what_nobody_looks_at_is_not_made(graph: Any, tmp_path: Path,
                                          monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []
    monkeypatch.setattr('bpc_perception.nodes.parts.views.MESSAGES', {
        name: lambda *_, name=name: made.append(name) for name in topics.VIEWS})
    bench = thickness(graph, tmp_path)
    bench.send(topics.PATH, PATH)
    bench.send_capture(STAMP)
    assert_profile_comes(bench, STAMP)
    assert made == []


def test_in_hand_poses_place_the_camera(graph: Any, tmp_path: Path) -> None:
    bench = thickness(graph, tmp_path, mount='eye_in_hand')
    bench.send(topics.PATH, PATH)
    bench.send_capture(STAMP)
    bench.send(topics.POSE, *(pose_to_message(STAMP + shift, BASE, np.eye(4))
                              for shift in (-10**7, 10**7)))
    assert_profile_comes(bench, STAMP)


def image_only(bench: Bench) -> None:
    image, info, _ = capture_to_messages(capture_of(band_image(), STAMP))
    bench.send(topics.IMAGE, image)
    bench.send(topics.CAMERA_INFO, info)


def test_an_image_without_cloud_is_given_up_after_a_while(graph: Any, tmp_path: Path) -> None:
    bench = thickness(graph, tmp_path, patience=0.2)
    bench.send(topics.PATH, PATH)
    image_only(bench)
    bench.until(lambda: bench.diagnosed('refused: capture') == '1')
    assert bench.diagnosed('last refusal').endswith('found no points/xyzrgba')
    bench.send_capture(STAMP + SECOND)
    assert_profile_comes(bench, STAMP + SECOND)


def smaller(messages: dict[str, Any]) -> None:
    messages[topics.CLOUD].height -= 1


def unorganized(messages: dict[str, Any]) -> None:
    for message in messages.values():
        message.width, message.height = message.width * message.height, 1
    messages[topics.IMAGE].step *= 120
    messages[topics.CLOUD].row_step *= 120


def mono(messages: dict[str, Any]) -> None:
    messages[topics.IMAGE].encoding = 'mono8'


def uncalibrated(messages: dict[str, Any]) -> None:
    messages[topics.CAMERA_INFO].k = [0.0] * 9


def truncated(messages: dict[str, Any]) -> None:
    cloud = messages[topics.CLOUD]
    cloud.data = cloud.data[:1000]


def without_depth(messages: dict[str, Any]) -> None:
    cloud = messages[topics.CLOUD]
    cloud.data = array('B', np.full(len(cloud.data) // 4, np.nan, np.float32).tobytes())


@pytest.mark.parametrize(('spoil', 'kind'), [
    (smaller, 'capture'), (unorganized, 'cloud'), (mono, 'image'), (uncalibrated, 'camera_info'),
    (truncated, 'cloud'), (without_depth, 'cloud')], ids=lambda value: getattr(
        value, '__name__', value))
def test_an_unusable_capture_is_counted_and_the_next_is_measured(
        graph: Any, tmp_path: Path, spoil: Any, kind: str) -> None:
    bench = thickness(graph, tmp_path)
    bench.send(topics.PATH, PATH)
    bench.send_capture(STAMP, spoil)
    bench.until(lambda: bench.diagnosed(f'refused: {kind}') == '1')
    assert bench.received[topics.PROFILE] == []
    bench.send_capture(STAMP + SECOND)
    assert_profile_comes(bench, STAMP + SECOND)


def test_a_capture_without_path_is_counted(graph: Any, tmp_path: Path) -> None:
    bench = thickness(graph, tmp_path, patience=0.1)
    bench.send_capture(STAMP)
    bench.until(lambda: bench.diagnosed('refused: path') == '1')
    assert bench.received[topics.PROFILE] == []


def elsewhere(message: Any) -> None:
    message.header.frame_id = 'world'


def torn(message: Any) -> None:
    message.x = message.x[:-1]


@pytest.mark.parametrize('spoil', [elsewhere, torn], ids=lambda spoil: spoil.__name__)
def test_an_unusable_path_is_counted_and_not_used(graph: Any, tmp_path: Path,
                                                  spoil: Any) -> None:
    bench = thickness(graph, tmp_path, patience=0.1)
    wrong = path_to_message(pixel_path((40, 55), (120, 55), 81), BASE)
    spoil(wrong)
    bench.send(topics.PATH, wrong)
    bench.until(lambda: bench.diagnosed('refused: deposition_path') == '1')
    bench.send_capture(STAMP)
    bench.until(lambda: bench.diagnosed('refused: path') == '1')
    assert bench.received[topics.PROFILE] == []


@pytest.mark.parametrize('frame', ['world', 'nan'])
def test_in_hand_unusable_poses_are_counted_and_not_used(graph: Any, tmp_path: Path,
                                                         frame: str) -> None:
    bench = thickness(graph, tmp_path, mount='eye_in_hand', patience=0.1)
    bench.send(topics.PATH, PATH)
    for shift in (-10**7, 10**7):
        message = pose_to_message(STAMP + shift, BASE, np.eye(4))
        if frame == 'nan':
            message.pose.position.x = np.nan
        else:
            message.header.frame_id = frame
        bench.send(topics.POSE, message)
    bench.until(lambda: bench.diagnosed('refused: pose') == '2')
    bench.send_capture(STAMP)
    bench.until(lambda: bench.diagnosed('refused: end_effector_pose') == '1')
    assert bench.received[topics.PROFILE] == []


def test_in_hand_poses_that_jump_or_come_twice_are_counted_and_not_used(
        graph: Any, tmp_path: Path) -> None:
    bench = thickness(graph, tmp_path, mount='eye_in_hand', patience=0.1)
    bench.send(topics.PATH, PATH)
    away = np.eye(4)
    away[:3, 3] = 0.5
    for shift, pose_then in ((-10**7, np.eye(4)), (-10**7, np.eye(4)), (10**7, away)):
        bench.send(topics.POSE, pose_to_message(STAMP + shift, BASE, pose_then))
    bench.until(lambda: bench.diagnosed('refused: pose') == '2')
    bench.send_capture(STAMP)
    bench.until(lambda: bench.diagnosed('refused: end_effector_pose') == '1')
    assert bench.received[topics.PROFILE] == []


def test_a_new_target_takes_effect_at_once(graph: Any, tmp_path: Path) -> None:
    bench = thickness(graph, tmp_path)
    bench.send(topics.PATH, PATH)
    result, = bench.node.set_parameters([Parameter('advice.target_thickness', value=0.0033)])
    assert result.successful
    bench.send_capture(STAMP)
    assert_profile_comes(bench, STAMP)
    advice = bench.received[topics.ADVICE][0]
    assert advice.target_thickness == 0.0033
    assert advice.reason in (RateAdvice.UNDER_EXTRUSION, RateAdvice.LIMITED)


@pytest.mark.parametrize(('name', 'value', 'reason'), [
    ('advice.target_thickness', 5.0, 'advice.target_thickness'),
    ('advice.target_thickness', 'wide', 'DOUBLE'),
    ('advice.target_thickness', float('nan'), 'advice.target_thickness'),
    ('segmentation.kernel_size', 4, 'odd'),
    ('segmentation.canny_low', 200.0, 'canny_high'),
    ('method', 'guess', 'paper'),
    ('base_frame', 'world', 'read-only'),
])
def test_a_bad_parameter_is_refused_at_run_time_with_the_reason(
        graph: Any, tmp_path: Path, name: str, value: Any, reason: str) -> None:
    bench = thickness(graph, tmp_path)
    before = bench.node.get_parameter(name).value
    result, = bench.node.set_parameters([Parameter(name, value=value)])
    assert not result.successful
    assert reason in result.reason
    assert bench.node.get_parameter(name).value == before


def test_values_that_only_fit_together_can_be_set_together(graph: Any, tmp_path: Path) -> None:
    node = thickness(graph, tmp_path).node
    result = node.set_parameters_atomically([Parameter('segmentation.canny_low', value=200.0),
                                             Parameter('segmentation.canny_high', value=300.0)])
    assert result.successful


@pytest.mark.parametrize(('name', 'value'), [
    ('patience', -1.0), ('patience', 'long'), ('patience', float('nan')),
    ('advice__minimum_samples', 0), ('segmentation__kernel_size', 4), ('method', 'guess')])
def test_a_bad_parameter_is_refused_at_the_start(graph: Any, tmp_path: Path, name: str,
                                                 value: Any) -> None:
    with pytest.raises(ConfigError, match=name.split('__')[-1]):
        thickness(graph, tmp_path, **{name: value})


@pytest.mark.parametrize('name', ['', '/nowhere/camera.calib'])
def test_an_unknown_calibration_is_refused_at_the_start(graph: Any, name: str) -> None:
    with pytest.raises(HandEyeError, match=r'expected a .*file, found'):
        graph.make(ThicknessNode, hand_eye_file=name)


def test_a_clock_that_goes_back_forgets_the_path(graph: Any, tmp_path: Path) -> None:
    bench = thickness(graph, tmp_path, use_sim_time=True, patience=0.1)
    bench.send(topics.PATH, PATH)
    for seconds in (100, 50):
        bench.send('/clock', Clock(clock=ns_to_stamp(seconds * SECOND)), kind=Clock, qos=10)
        bench.until(lambda seconds=seconds: bench.node.get_clock().now().nanoseconds
                    == seconds * SECOND)
    bench.send_capture(STAMP)
    bench.until(lambda: bench.diagnosed('refused: path') == '1')
    assert bench.received[topics.PROFILE] == []


def test_every_parameter_has_a_description_and_limits(graph: Any, tmp_path: Path) -> None:
    node = thickness(graph, tmp_path).node
    descriptor = node.describe_parameter('advice.target_thickness')
    assert 'Thickness wanted' in descriptor.description
    assert '[m]' in descriptor.description
    assert descriptor.floating_point_range[0].to_value == 0.1
    assert node.describe_parameter('segmentation.kernel_size').integer_range[0].from_value == 1
    assert node.describe_parameter('base_frame').read_only


# The camera driver, with a recording as camera


def recording(folder: Path, count: int = 3) -> str:
    path = folder / 'bag'
    with BagWriter(path) as writer:
        for name, kind in topics.CAMERA.items():
            writer.add_topic(f'/{name}', topics.type_name(kind))
        for number in range(count):
            stamp_ns = START_NS + number * SECOND
            for name, message in zip(
                    topics.CAMERA, capture_to_messages(capture_of(band_image(), stamp_ns)),
                    strict=True):
                writer.write(f'/{name}', stamp_ns, message)
    return str(path)


def stamps(messages: list[Any]) -> list[int]:
    return [(stamp_to_ns(message.header.stamp) - START_NS) // SECOND for message in messages]


def test_a_recording_is_delivered_to_those_who_listen_to_all_of_it(graph: Any,
                                                                  tmp_path: Path) -> None:
    bench = Bench(graph, CameraDriverNode, back_end='bag', bag=recording(tmp_path))
    images = bench.listen(topics.IMAGE, topics.CAMERA[topics.IMAGE], topics.CAMERA_QOS)
    ticks: list[int] = []
    bench.peer.create_timer(0.05, lambda: ticks.append(1))
    bench.until(lambda: len(ticks) == 4)  # the driver has looked several times by now
    assert images == []
    for name in (topics.CAMERA_INFO, topics.CLOUD):
        bench.listen(name, topics.CAMERA[name], topics.CAMERA_QOS)
    bench.until(lambda: all(len(bench.received[name]) == 3 for name in topics.CAMERA))
    for name in topics.CAMERA:
        assert stamps(bench.received[name]) == [0, 1, 2]
    assert images[0] == capture_to_messages(capture_of(band_image(), START_NS))[0]


def test_a_capture_can_be_asked_for(graph: Any, tmp_path: Path) -> None:
    bench = Bench(graph, CameraDriverNode, back_end='bag', bag=recording(tmp_path, 2))
    images = bench.listen(topics.IMAGE, topics.CAMERA[topics.IMAGE], topics.CAMERA_QOS)
    for number in (1, 2):
        answer = bench.call('capture')
        assert (answer.success, answer.message) == (True, '')
        bench.until(lambda number=number: len(images) == number)
    assert stamps(images) == [0, 1]
    answer = bench.call('capture')
    assert not answer.success
    assert answer.message.startswith('capture: expected a recorded capture')
    bench.until(lambda: bench.diagnosed('refused: capture') == '1')
    assert bench.diagnosed('captures') == '2'


def test_a_capture_is_handed_over_before_it_is_published(graph: Any, tmp_path: Path) -> None:
    order: list[str] = []

    class Turn(Event):
        def wait(self, timeout: float | None = None) -> bool:
            order.append('waited' if timeout else 'went on')
            return True

    def hand_over(capture: Any) -> Event:
        order.append(f'handed over {(capture.stamp_ns - START_NS) // SECOND}')
        return Turn()

    bag = recording(tmp_path, 2)
    bench = Bench(graph, partial(CameraDriverNode, hand_over), back_end='bag', bag=bag, rate=0.0)
    bench.until(lambda: len(order) == 4)  # though nobody listens
    assert order == ['handed over 0', 'went on', 'handed over 1', 'went on']
    order.clear()
    images = bench.listen(topics.IMAGE, topics.CAMERA[topics.IMAGE], topics.CAMERA_QOS)
    bench.node._camera = BagCamera(Bag(bag))
    bench.until(lambda: len(images) == 2)
    assert order == ['handed over 0', 'waited', 'handed over 1', 'waited']


def test_a_region_of_captures_keeps_its_place(graph: Any, tmp_path: Path) -> None:
    region = [21, 40, 110, 33]
    bench = Bench(graph, CameraDriverNode, back_end='bag', bag=recording(tmp_path, 2),
                  region=region)
    for name in topics.CAMERA:
        bench.listen(name, topics.CAMERA[name], topics.CAMERA_QOS)
    bench.until(lambda: all(len(bench.received[name]) == 2 for name in topics.CAMERA))
    whole = capture_of(band_image(), START_NS)
    part = capture_from_messages(*(bench.received[name][0] for name in topics.CAMERA))
    assert part.image.tolist() == whole.image[40:73, 21:131].tolist()
    np.testing.assert_array_equal(part.cloud, whole.cloud[40:73, 21:131])
    # A point is seen at the pixel at which it lies in the cloud.
    np.testing.assert_allclose(part.camera.pixels(part.cloud[12, 34].astype(float)), (34, 12),
                               atol=1e-3)
    bench.node.set_parameters([Parameter('region', value=[100, 0, 61, 10])])
    bench.node._camera = BagCamera(Bag(recording(tmp_path / 'again', 1)))
    bench.until(lambda: bench.diagnosed('refused: region') == '1')
    assert bench.diagnosed('last refusal').endswith('found 61 x 10 at (100, 0)')


def test_an_unknown_back_end_is_refused(graph: Any) -> None:
    with pytest.raises(ValueError, match=r'back_end: expected one of .*bag.* found .*webcam'):
        graph.make(CameraDriverNode, back_end='webcam')


def test_a_missing_recording_is_refused(graph: Any, tmp_path: Path) -> None:
    with pytest.raises(BagError, match='expected a bag, found nothing there'):
        graph.make(CameraDriverNode, back_end='bag', bag=str(tmp_path / 'none'))


def test_a_negative_rate_is_refused(graph: Any, tmp_path: Path) -> None:
    node = graph.make(CameraDriverNode, back_end='bag', bag=recording(tmp_path, 1))
    result, = node.set_parameters([Parameter('rate', value=-1.0)])
    assert not result.successful


# As processes


def test_a_node_that_cannot_start_says_why_in_one_line_and_exits_with_2() -> None:
    ended = subprocess.run(
        [sys.executable, '-m', 'bpc_perception.nodes.thickness', '--ros-args', '-p',
         'hand_eye_file:=/nowhere/camera.calib'],
        capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 2
    line, = ended.stderr.splitlines()
    assert '/nowhere/camera.calib: expected a readable YAML file, found' in line


@pytest.mark.parametrize('numbers', [
    [signal.SIGTERM],
    [signal.SIGHUP],
    [signal.SIGINT, signal.SIGINT],  # of the terminal and of ros2 launch
    # Of the kernel, one for each thread of a parent that was killed; and of the impatient.
    [signal.SIGTERM] * 1000,
    [signal.SIGINT] * 1000,
], ids=['SIGTERM', 'SIGHUP', 'SIGINT', 'many SIGTERM', 'many SIGINT'])
def test_a_node_ends_when_told_to(graph: Any, ros_domain: int, numbers: list[signal.Signals],
                                  monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    peer = graph.make(Node, 'peer')
    with subprocess.Popen([sys.executable, '-m', 'bpc_perception.nodes.path_recorder'],
                          stderr=subprocess.PIPE, text=True) as process:
        try:
            graph.spin_until(lambda: 'path_recorder' in peer.get_node_names(), 30)
            for number in numbers:
                process.send_signal(number)
                time.sleep(0.005)  # or else two of a kind are one
                if process.poll() is not None:
                    break
            _, errors = process.communicate(timeout=20)
        finally:
            process.kill()
    assert process.returncode == 0
    assert 'Traceback' not in errors
    # It took its leave: of who does not, the graph keeps the publishers for another 20 s.
    graph.spin_until(lambda: peer.count_publishers(topics.PATH) == 0, 10)


FAILING = """
from bpc_perception.runtime.run import run
from rclpy.node import Node

class Failing(Node):
    def __init__(self):
        super().__init__('failing')
        self.create_timer(0.1, self.fail)

    def fail(self):
        raise RuntimeError('the node has failed')

"""


@pytest.mark.parametrize('made', ['Failing()', "(Failing(), Node('good'))",
                                  "(Node('good'), Failing())"])
def test_a_node_that_fails_says_so_and_takes_its_process_with_it(
        ros_domain: int, monkeypatch: pytest.MonkeyPatch, made: str) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    ended = subprocess.run([sys.executable, '-c', f'{FAILING}run(lambda: {made})'],
                           capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 1
    assert 'RuntimeError: the node has failed' in ended.stderr


HANGS = """
import ctypes
from bpc_perception.runtime.run import run
from rclpy.node import Node

class Hangs(Node):
    def __init__(self):
        super().__init__('hangs')
        print('made', flush=True)

    def destroy_node(self):
        ctypes.PyDLL(None).sleep(60)  # with the interpreter's lock

run(Hangs)
"""


def test_a_child_whose_end_hangs_in_cpp_ends_all_the_same(
        ros_domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    monkeypatch.setenv('BPC_PARENT', str(os.getpid()))
    with subprocess.Popen([sys.executable, '-c', HANGS], stdout=subprocess.PIPE,
                          text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == 'made\n'
            process.terminate()
            process.wait(30)
        finally:
            process.kill()
    assert process.returncode == -signal.SIGALRM


TOLD = """
import os, signal, sys, time
from bpc_perception.runtime.run import run
import rclpy
from rclpy.node import Node
from std_msgs.msg import Empty

# As the command line does, in whose process a node may run.
signal.signal(signal.SIGTERM, signal.default_int_handler)

class Told(Node):
    def __init__(self):
        super().__init__('told')
        if sys.argv[2] == 'half':
            os.kill(os.getpid(), int(sys.argv[1]))
            time.sleep(0.3)
        self.create_publisher(Empty, 'topic', 1)
        print('made', flush=True)
        if sys.argv[2] == 'made':
            os.kill(os.getpid(), int(sys.argv[1]))

    def destroy_node(self):
        print('completed', flush=True)
        super().destroy_node()

def init(before=rclpy.init, **given):
    if sys.argv[2] == 'early':
        os.kill(os.getpid(), int(sys.argv[1]))
    before(**given)

rclpy.init = init
run(Told)
"""


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(('moment', 'words'), [
    ('early', ''), ('half', 'made\ncompleted\n'), ('made', 'made\ncompleted\n')])
def test_told_to_end_while_it_starts_a_node_leaves_nothing_half_made(
        ros_domain: int, monkeypatch: pytest.MonkeyPatch, number: signal.Signals, moment: str,
        words: str) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    ended = subprocess.run([sys.executable, '-c', TOLD, str(int(number)), moment],
                           capture_output=True, text=True, timeout=60, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, words, '')


LISTENS = """
from bpc_perception.runtime.run import run
from rclpy.node import Node
from std_msgs.msg import Empty

class Listens(Node):
    def __init__(self):
        super().__init__('listens')
        self.create_subscription(Empty, 'topic', lambda _: print('heard', flush=True), 1)

run(Listens, large_messages={})
"""


@pytest.fixture
def shared_memory_ports(graph: Any, ros_domain: int, monkeypatch: pytest.MonkeyPatch,
                        ) -> Callable[[bool], list[int]]:
    """At which ports a node, that then is killed, hears messages through shared memory."""
    for name, value in with_profile(os.environ).items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    node = graph.make(partial(Node, 'talks'))
    publisher = node.create_publisher(Empty, 'topic', 1)
    node.create_timer(0.02, lambda: publisher.publish(Empty()))
    own = range(7400 + 250 * ros_domain, 7650 + 250 * ros_domain)

    def ports(large_messages: bool) -> list[int]:
        with subprocess.Popen([sys.executable, '-c', LISTENS.format(large_messages)],
                              stdout=subprocess.PIPE) as process:
            try:
                graph.spin_until(lambda: select.select([process.stdout], [], [], 0)[0])
                assert process.stdout is not None
                assert process.stdout.readline() == b'heard\n'
                found = re.findall(r'fastrtps_port(\d+)_el', ' '.join(
                    os.readlink(file) for file in Path(f'/proc/{process.pid}/fd').iterdir()))
            finally:
                process.kill()
        return [int(number) for number in found if int(number) in own]

    return ports


def test_nodes_one_after_another_listen_on_different_ports(
        shared_memory_ports: Callable[[bool], list[int]]) -> None:
    """Whoever wrote to one that was killed may write to its port for ever."""
    # Of 89 numbers; that four are one is as likely as one in 700 000.
    found = [shared_memory_ports(True) for _ in range(4)]
    assert {len(ports) for ports in found} == {1}
    assert len({port for port, in found}) > 1


def test_who_takes_no_captures_hears_nothing_through_shared_memory(
        shared_memory_ports: Callable[[bool], list[int]]) -> None:
    """There a publisher that is killed may leave a lock for which it would wait a second."""
    assert shared_memory_ports(False) == []


def test_the_pose_used_here_is_the_one_of_the_calibration(tmp_path: Path) -> None:
    from bpc_perception.files.hand_eye_file import load_hand_eye

    file = tmp_path / 'camera.calib'
    file.write_text(CALIBRATION.format(mount='eye_on_base'))
    T: Array = load_hand_eye(file).T_parent_camera
    np.testing.assert_allclose(T, DOWN, atol=1e-15)
    np.testing.assert_allclose(T, pose((0, 0, 0.5), (0, 0, 180)), atol=1e-15)
