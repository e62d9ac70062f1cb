"""What ``bpc check`` listens to."""

from __future__ import annotations

import time

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
import numpy as np
import pytest
from rclpy.node import Node
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from bpc_perception.cli.parts.preflight import FAIL, WARN
from bpc_perception.cli.parts.rig_listener import (
    DISCOVERY_S,
    PARTS_PATIENCE_S,
    RigListener,
)
from bpc_perception.core.config import RecorderConfig
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.messages import topics
from bpc_perception.messages.poses.pose import pose_to_message
from bpc_perception.runtime.isolated_graph import Graph
from bpc_perception.runtime.transport.dds_profiles import FOLDER

pytestmark = pytest.mark.ros


@pytest.mark.parametrize('camera', [True, False])
def test_a_camera_that_live_is_going_to_drive_is_not_missed(graph: Graph, camera: bool) -> None:
    listener = RigListener(graph.make(Node, 'check'), RecorderConfig(), {}, camera)
    named = {finding.subject for finding in listener.findings()}
    assert named == {'/end_effector_pose', '/extrusion_state', *(
        ('/color/image_color', '/color/camera_info', '/points/xyzrgba') if camera else ())}


def test_poses_in_another_frame_are_called_that_and_nothing_else(graph: Graph) -> None:
    listener = RigListener(graph.make(Node, 'check'), RecorderConfig(), {}, camera=False)
    poses = graph.make(Node, 'robot').create_publisher(PoseStamped, topics.POSE, topics.POSE_QOS)
    graph.spin_until(poses.get_subscription_count, 10)
    for _ in range(50):
        poses.publish(pose_to_message(time.time_ns(), 'world', np.eye(4)))
        graph.spin_until(lambda: True, 0.01)
    heard = next(each for each in listener._heard if each.kind == 'pose')
    graph.spin_until(lambda: len(heard.arrivals) > 40, 10)
    found = [each for each in listener.findings() if '/end_effector_pose' in each.subject]
    frame, rate, clock = found
    assert frame.level == FAIL
    assert frame.found == 'pose: expected frame lbr_link_0, found world'
    assert frame.todo == ('set base_frame of path_recorder and thickness to world, or publish in '
                          'lbr_link_0')
    assert rate.found.endswith('Hz')
    assert 'no stamps' not in clock.found


def test_a_calibration_of_another_camera_is_called_that(graph: Graph) -> None:
    listener = RigListener(graph.make(Node, 'check'), RecorderConfig(), {},
                           calibration=HandEye(True, np.eye(4), 'lbr_link_0', 'camera_link'))
    images = graph.make(Node, 'camera').create_publisher(Image, topics.IMAGE, topics.CAMERA_QOS)
    graph.spin_until(images.get_subscription_count, 10)
    images.publish(Image(header=Header(frame_id='camera_optical_frame'), height=8, width=8,
                         step=24, encoding='rgb8', data=bytes(192)))
    graph.spin_until(lambda: bool(listener._image), 10)
    frames, = (each for each in listener.findings() if 'calibration' in each.subject)
    assert frames.level == WARN
    assert 'camera frame camera_link instead of camera_optical_frame' in frames.found


def test_captures_that_are_lost_to_little_shared_memory_are_called_that(
        graph: Graph, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    listener = RigListener(graph.make(Node, 'check'), RecorderConfig(), {})
    camera = graph.make(Node, 'camera')
    publishers = {name: camera.create_publisher(kind, name, topics.CAMERA_QOS)
                  for name, kind in topics.CAMERA.items()}
    graph.spin_until(lambda: all(
        each.get_subscription_count() for each in publishers.values()), 10)
    listener._since -= DISCOVERY_S
    heard = {each.topic[1:]: each for each in listener._heard}
    for number, lost in enumerate(((), (topics.CLOUD,), (topics.IMAGE, topics.CLOUD))):
        stamp = Time(sec=round(time.time()) - 1, nanosec=number)
        for name in topics.CAMERA.keys() - set(lost):
            publishers[name].publish(topics.CAMERA[name](header=Header(stamp=stamp)))
            graph.spin_until(lambda name=name, stamp=stamp: any(
                ns % 10**9 == stamp.nanosec for ns in heard[name].stamps), 10)
    soon = {each.subject: each for each in listener.findings()}
    assert 'came without' not in soon[f'/{topics.CLOUD}'].found  # it may still be under way
    listener._since -= PARTS_PATIENCE_S
    for each in listener._heard:
        each.arrivals = [at - PARTS_PATIENCE_S for at in each.arrivals]
    found = {each.subject: each for each in listener.findings()}
    cloud, image = found[f'/{topics.CLOUD}'], found[f'/{topics.IMAGE}']
    assert (cloud.level, cloud.found) == (FAIL, '2 of 3 captures came without it')
    assert (image.level, image.found) == (FAIL, '1 of 3 captures came without it')
    for each in (cloud, image):
        assert 'too little shared memory' in each.todo
        assert each.todo.endswith(f'PROFILES_FILE set to {FOLDER / "local_transport.xml"}')
