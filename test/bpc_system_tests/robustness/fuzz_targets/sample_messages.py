"""A small print as messages: what the seeds are made of."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseStamped
import numpy as np
from sensor_msgs.msg import JointState

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.path import path_to_message


def small_capture() -> Capture:
    """Return a dark band on a light bed, 40 pixels wide, on a plane half a metre away."""
    image = np.full((32, 40, 3), 200, np.uint8)
    image[12:20] = 40
    v, u = np.mgrid[:32, :40]
    cloud = np.stack(((u - 20) * 2e-4, (v - 16) * 2e-4, np.full(u.shape, 0.5)), -1)
    return Capture(5 * 10**9, 'camera', image, cloud.astype(np.float32),
                   PinholeCamera(np.array(((2500.0, 0, 20), (0, 2500.0, 16), (0, 0, 1))),
                                 np.zeros(5), 40, 32))


def straight_path() -> DepositionPath:
    """Return a path along the band, in the frame of the camera."""
    count = 30
    s = np.arange(count) * 2e-4
    return DepositionPath('print', 10**9, 10.0, True, s * 100, s,
                          np.column_stack((s - 3e-3, np.zeros(count), np.full(count, 0.5))),
                          np.full(count, 1e-5), np.full(count, 1e-9), np.ones(count, bool),
                          np.ones(count, bool))


def recorded_messages() -> list[tuple[str, Any]]:
    """Return what a recording holds, as (topic, message)."""
    pose = PoseStamped()
    pose.header.frame_id = 'lbr_link_0'
    pose.pose.orientation.w = 1.0
    joints = JointState(name=[f'lbr_A{number}' for number in range(1, 8)], position=[0.1] * 7,
                        velocity=[0.0] * 7)
    return [(topics.POSE, pose), (topics.JOINTS, joints), (topics.EXTRUSION, ExtrusionState()),
            (topics.PATH, path_to_message(straight_path(), 'lbr_link_0')),
            *zip(topics.CAMERA, capture_to_messages(small_capture()), strict=True)]
