"""``bpc check`` with a rig that has faults, and with one that has none."""

from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path
import subprocess
import threading
import time
from typing import Any

from geometry_msgs.msg import PoseStamped
import numpy as np
import pytest
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Bool

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.poses.pose import pose_to_message
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.runtime.isolated_graph import Graph
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_system_tests.parts.command_line import command, PATIENCE_S, SAMPLE
from bpc_system_tests.parts.ros_graph import own_domain

pytestmark = [pytest.mark.system, pytest.mark.ros]
SEEN = SCENARIOS['line'](0.02).capture(2.0, 0)


class Rig:
    """Publishes the messages of a rig from its own thread; faults can be set."""

    def __init__(self, graph: Graph) -> None:
        self.node: Node = graph.make(Node, 'rig')
        self.frame, self.ahead_ns, self.errors = 'lbr_link_0', 0, 0
        self._poses = self.node.create_publisher(PoseStamped, topics.POSE, topics.POSE_QOS)
        self._states = self.node.create_publisher(
            ExtrusionState, topics.EXTRUSION, topics.EXTRUSION_QOS)
        self._camera = [self.node.create_publisher(kind, name, topics.CAMERA_QOS)
                        for name, kind in topics.CAMERA.items()]
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        ticks = 0
        while not self._ended.wait(0.01):
            now_ns = time.time_ns() + self.ahead_ns
            self._poses.publish(pose_to_message(now_ns, self.frame, np.eye(4)))
            state = ExtrusionState(flow_rate=1e-8, error_status=self.errors)
            state.header.stamp = ns_to_stamp(time.time_ns())
            self._states.publish(state)
            ticks += 1
            if ticks % 50 == 0:
                stamp = ns_to_stamp(time.time_ns())
                for publisher, message in zip(self._camera, capture_to_messages(SEEN),
                                              strict=True):
                    message.header.stamp = stamp
                    publisher.publish(message)

    def end(self) -> None:
        self._ended.set()
        self._thread.join()


@pytest.fixture(scope='module')
def rig() -> Iterator[Rig]:
    with own_domain() as domain:
        graph = Graph(domain)
        made = Rig(graph)
        yield made
        made.end()
        graph.close()


def check(*options: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command('check', '--handeye', SAMPLE / 'hand_eye.calib', '--seconds', 6, *options),
        stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE_S, check=False,
        # It has to keep nothing.
        env=os.environ | {'HOME': '/proc/nowhere', 'ROS_LOG_DIR': '/proc/nowhere'})


def lines(ended: subprocess.CompletedProcess[str], level: str) -> list[str]:
    assert ended.stderr == ''
    return [line for line in ended.stdout.splitlines() if line.startswith(level)]


def test_a_rig_in_order_passes(rig: Rig) -> None:
    assert rig.frame
    ended = check('--params', SAMPLE / 'params.yaml')
    assert lines(ended, 'FAIL') == []
    assert ended.returncode == 0
    good = '\n'.join(lines(ended, 'OK'))
    for name in (*topics.CAMERA, topics.POSE, topics.EXTRUSION):
        assert f'/{name}: ' in good or f'/{name}: ' in '\n'.join(lines(ended, 'WARN')), name
    for subject in ('hand-eye calibration', 'target thickness', 'nozzle offset', 'clock of',
                    'middleware', 'extruder'):
        assert subject in good, subject


def test_faults_are_named(rig: Rig) -> None:
    before: tuple[Any, ...] = rig.frame, rig.ahead_ns, rig.errors
    rig.frame, rig.errors = 'world', 1 << 2
    others = [rig.node.create_publisher(Bool, '/another', topics.RESULT_QOS),
              rig.node.create_publisher(CameraInfo, topics.CAMERA_INFO, topics.CAMERA_QOS)]
    try:
        ended = check('--remap', 'color/image_color:=/elsewhere',
                      '--remap', 'points/xyzrgba:=/another')
    finally:
        rig.frame, rig.ahead_ns, rig.errors = before
        for other in others:
            rig.node.destroy_publisher(other)
    assert ended.returncode == 1
    failed = '\n'.join(lines(ended, 'FAIL'))
    assert 'nozzle offset: none' in failed
    assert 'expected frame lbr_link_0, found world' in failed
    assert 'the motor is stopped: low VIN' in failed
    assert '/elsewhere: nobody publishes it' in failed
    assert '/another: is std_msgs/msg/Bool, expected sensor_msgs/msg/PointCloud2' in failed
    assert '/color/camera_info: 2 publish it' in failed


def test_a_robot_whose_clock_is_ahead_is_named(rig: Rig, tmp_path: Path) -> None:
    (tmp_path / 'params.yaml').write_text((SAMPLE / 'params.yaml').read_text())
    rig.ahead_ns = 500 * 10**6
    try:
        ended = check('--params', tmp_path / 'params.yaml', '--camera', 'zivid')
    finally:
        rig.ahead_ns = 0
    assert '/color/' not in ended.stdout
    # A busy computer may fail in other things as well.
    failed = [line for line in lines(ended, 'FAIL') if 'clock of /end_effector_pose' in line]
    assert len(failed) == 1, ended.stdout
    assert 'stamps are' in failed[0]
    assert 'ahead of this computer' in failed[0]
