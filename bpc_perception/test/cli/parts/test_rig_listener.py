"""What ``bpc check`` listens to."""

from __future__ import annotations

import time

from geometry_msgs.msg import PoseStamped
import numpy as np
import pytest
from rclpy.node import Node

from bpc_perception.cli.parts.preflight import FAIL
from bpc_perception.cli.parts.rig_listener import RigListener
from bpc_perception.core.config import RecorderConfig
from bpc_perception.messages import topics
from bpc_perception.messages.pose import pose_to_message
from bpc_perception.runtime.isolated_graph import Graph

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
