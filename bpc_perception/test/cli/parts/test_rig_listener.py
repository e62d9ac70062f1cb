"""What ``bpc check`` listens to."""

from __future__ import annotations

import pytest
from rclpy.node import Node

from bpc_perception.cli.parts.rig_listener import RigListener
from bpc_perception.core.config import RecorderConfig
from bpc_perception.runtime.isolated_graph import Graph

pytestmark = pytest.mark.ros


@pytest.mark.parametrize('camera', [True, False])
def test_a_camera_that_live_is_going_to_drive_is_not_missed(graph: Graph, camera: bool) -> None:
    listener = RigListener(graph.make(Node, 'check'), RecorderConfig(), {}, camera)
    named = {finding.subject for finding in listener.findings()}
    assert named == {'/end_effector_pose', '/extrusion_state', *(
        ('/color/image_color', '/color/camera_info', '/points/xyzrgba') if camera else ())}
