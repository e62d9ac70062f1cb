"""Captures that cannot be measured are refused by name: recorded, and while a print runs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bpc_perception.core.config import BASE
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.messages import topics
from bpc_perception.messages.path import path_to_message
from bpc_perception.messages.stamps import ns_to_stamp, stamp_to_ns
from bpc_perception.runtime.child_processes import Nodes
from bpc_sim.printer.print_recording import START_NS
from bpc_sim.printer.scenarios import line
from bpc_system_tests.parts.command_line import OUTPUTS, refusal, succeed
from bpc_system_tests.parts.ros_graph import Listener, listening, own_domain
from bpc_system_tests.parts.spoiled_captures import (
    captures,
    CHANGES,
    Messages,
    spoil,
    write_spoiled,
)

pytestmark = [pytest.mark.system, pytest.mark.ros]

JOB = line(0.025)  # that of the short bag
SPOILED = [pytest.param(*change, id=name) for name, change in CHANGES.items()]

# Topics that are missing, and the words of the refusal.
MISSING = {
    'cloud': (['/points/xyzrgba'], 'expected one topic points/xyzrgba (sensor_msgs/msg/'),
    'image': (['/color/image_color'], 'expected one topic color/image_color (sensor_msgs/msg/'),
    'captures': ([f'/{name}' for name in topics.CAMERA], 'expected one topic color/image_color'),
    'poses': (['/end_effector_pose'], 'expected one topic end_effector_pose (geometry_msgs/msg/'),
    'extruder': (['/extrusion_state'], 'expected one topic extrusion_state (bpc_interfaces/msg/'),
}


@pytest.mark.parametrize(('change', 'words'), SPOILED)
def test_spoiled_recording_is_refused(change: Any, words: list[str], short_bag: Path,
                                      tmp_path: Path) -> None:
    bag = write_spoiled(short_bag, tmp_path / 'bag', change)
    said = refusal('measure', bag, '--out', tmp_path / 'out')
    assert said.startswith(f'bpc: {bag}: expected a capture that can be measured')
    assert all(word in said for word in words), said
    assert not (tmp_path / 'out').exists()


@pytest.mark.parametrize(('left_out', 'words'), MISSING.values(), ids=MISSING)
def test_missing_topic_is_named(left_out: list[str], words: str, short_bag: Path,
                                tmp_path: Path) -> None:
    bag = write_spoiled(short_bag, tmp_path / 'bag', leave_out=frozenset(left_out))
    said = refusal('measure', bag, '--out', tmp_path / 'out')
    assert said.startswith(f'bpc: {bag}: {words}')
    assert 'found none among /' in said
    assert not (tmp_path / 'out').exists()


def test_topics_without_messages_are_refused(short_bag: Path, tmp_path: Path) -> None:
    bag = write_spoiled(short_bag, tmp_path / 'bag', change=Messages.clear)
    said = refusal('measure', bag, '--out', tmp_path / 'out')
    assert said == f'bpc: {bag}: expected a capture that can be measured, found: no capture'
    assert not (tmp_path / 'out').exists()


def test_camera_in_hand_needs_poses_around_the_capture(short_bag: Path, tmp_path: Path) -> None:
    calibration = tmp_path / 'in_hand.calib'
    calibration.write_text((short_bag / 'hand_eye.calib').read_text().replace(
        'eye_on_base', 'eye_in_hand'))
    settings = tmp_path / 'strict.yaml'
    settings.write_text('thickness: {ros__parameters: {maximum_pose_gap: 0.001}}\n')
    bag = write_spoiled(short_bag, tmp_path / 'bag', between_poses)
    said = refusal('measure', bag, '--out', tmp_path / 'out', '--handeye', calibration,
                   '--params', settings)
    assert 'expected poses around the capture, found none near enough in time' in said
    assert not (tmp_path / 'out').exists()


def test_good_captures_are_measured_beside_a_spoiled_one(short_bag: Path,
                                                        tmp_path: Path) -> None:
    """Control: a recording that write_spoiled copies without a change can be measured."""
    bag = write_spoiled(short_bag, tmp_path / 'bag', change=lambda _: None)
    succeed('measure', bag, '--out', tmp_path / 'out')
    succeed('measure', short_bag, '--out', tmp_path / 'again')
    assert {file.name for file in (tmp_path / 'out').iterdir()} == OUTPUTS
    assert (tmp_path / 'out' / 'profile.csv').read_bytes() == (
        tmp_path / 'again' / 'profile.csv').read_bytes()


def between_poses(messages: Messages) -> None:
    for message in messages.values():
        message.header.stamp = ns_to_stamp(stamp_to_ns(message.header.stamp) + 4_000_000)


@dataclass
class Rig:
    """A thickness node as a process; the test plays camera and robot, and listens."""

    nodes: Nodes
    listener: Listener
    publishers: dict[str, Any]
    stamp_ns: int

    def show(self, messages: Messages) -> int:
        """Publish a capture as if taken a second after the last one; return its stamp [ns]."""
        self.stamp_ns += 10**9
        for name, message in messages.items():
            message.header.stamp = ns_to_stamp(self.stamp_ns)
            self.publishers[name].publish(message)
        return self.stamp_ns

    def publish_path(self) -> None:
        """Publish the path of the complete print."""
        self.publishers[topics.PATH].publish(path_to_message(true_path(), BASE))

    def expect_refusal(self) -> str:
        """Wait for a warning of the node, which must not have published a result."""
        self.listener.wait(lambda: self.listener.complaints('thickness'), self.nodes)
        assert self.listener.profiles == self.listener.advice == []
        said, = self.listener.complaints('thickness')
        return said

    def expect_a_measurement(self, good: Messages, complaints: int = 1) -> None:
        """Publish a good capture; the node must be alive, and measure this capture only."""
        stamp_ns = self.show(spoil(good, lambda _: None))
        # Profile and advice may arrive in any order.
        self.listener.wait(lambda: self.listener.profiles and self.listener.advice, self.nodes)
        profile, = self.listener.profiles
        assert stamp_to_ns(profile.header.stamp) == stamp_ns
        assert profile.print_id == 'line'
        assert profile.coverage > 0.95
        assert profile.thickness_mean == pytest.approx(2e-3, abs=0.05e-3)
        assert len(self.listener.complaints('thickness')) == complaints


def true_path() -> DepositionPath:
    """Return the path of the short bag's print, as the path recorder would give it."""
    s = np.arange(0.0, JOB.length, 0.2e-3)
    times = s / JOB.speed
    at = times + JOB.dwell_before
    return DepositionPath(
        print_id='line', start_ns=START_NS + round(JOB.dwell_before * 1e9),
        complete_until=JOB.duration, finished=True, time=times, arc_length=s, points=JOB.tip(at),
        plunger_velocity=JOB.plunger_velocity(at), flow_rate=JOB.flow_rate(at),
        extruding=JOB.extruding(at), extruder_known=np.ones(len(s), bool))


@contextmanager
def running_rig(short_bag: Path) -> Iterator[Rig]:
    with own_domain() as domain, listening(domain) as listener, Nodes() as nodes:
        qos = dict.fromkeys(topics.CAMERA, topics.CAMERA_QOS) | {topics.PATH: topics.PATH_QOS}
        kinds = topics.CAMERA | topics.RESULTS
        publishers = {name: listener.node.create_publisher(kinds[name], name, quality)
                      for name, quality in qos.items()}
        nodes.start('bpc_perception.nodes.thickness', patience=0.5,
                    hand_eye_file=str(short_bag / 'hand_eye.calib'))
        listener.wait(lambda: listener.heard['/diagnostics'] and all(
            publisher.get_subscription_count() for publisher in publishers.values()), nodes)
        yield Rig(nodes, listener, publishers, START_NS + round(JOB.duration * 1e9))


@pytest.fixture(scope='module')
def common_rig(short_bag: Path) -> Iterator[Rig]:
    with running_rig(short_bag) as rig:
        rig.publish_path()
        yield rig


@pytest.fixture
def rig(common_rig: Rig) -> Rig:
    """One thickness node for all tests: that it survives is part of the test."""
    common_rig.listener.forget()
    return common_rig


@pytest.fixture(scope='module')
def good(short_bag: Path) -> Messages:
    """The capture of the complete print."""
    return captures(short_bag)[-1]


@pytest.mark.parametrize(('change', 'words'), SPOILED)
def test_spoiled_capture_is_refused_and_the_next_measured(
        change: Any, words: list[str], good: Messages, rig: Rig) -> None:
    rig.show(spoil(good, change))
    said = rig.expect_refusal()
    assert all(word in said for word in words), said
    rig.expect_a_measurement(good)


def test_capture_without_a_print_is_no_fault(good: Messages, short_bag: Path) -> None:
    with running_rig(short_bag) as rig:
        rig.show(spoil(good, lambda _: None))
        rig.listener.wait(lambda: any(
            status.message == 'path: expected a print, found none started; push ink out, or call '
            'path_recorder/start' for message in rig.listener.heard['/diagnostics']
            for status in message.status if status.name == 'thickness'), rig.nodes)
        rig.publish_path()
        rig.expect_a_measurement(good, complaints=0)
