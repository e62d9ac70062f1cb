"""Convert poses of the flange from and to the messages of any robot."""

from __future__ import annotations

import math
from typing import Any

from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion, Transform
import numpy as np
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from bpc_perception.core.arrays import Array
from bpc_perception.core.robot.kinematics import flange_pose, order_joints
from bpc_perception.core.robot.poses import pose_matrix
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp

LARGEST_DISTANCE_M = 20.0  # of anything from a robot's base; what is farther has another unit


def pose_to_matrix(message: Pose) -> Array:
    """Return the transform (4, 4) [m] of a pose. Raises ConversionError when it is none."""
    p, q = message.position, message.orientation
    distance = math.hypot(p.x, p.y, p.z)
    if LARGEST_DISTANCE_M < distance < math.inf:
        raise ConversionError(f'pose: expected a position in metres, found one {distance:.0f} m '
                              'away; is it in millimetres?')
    try:
        return pose_matrix((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))
    except ValueError as error:
        raise ConversionError(f'{error}; look at what publishes it') from error


def joints_to_matrix(message: JointState, robot: str) -> Array:
    """Return T_base_flange (4, 4) [m] of a robot with joints among those of the message.

    Raises ConversionError.
    """
    try:
        return flange_pose(robot, order_joints(message.name, message.position))
    except ValueError as error:
        raise ConversionError(f'joint_states: {error}') from error


def lbr_state_to_matrix(message: Any, robot: str) -> tuple[int, Array]:
    """Return controller time [ns] and T_base_flange (4, 4) [m] of an lbr_fri_idl/LBRState.

    Raises ConversionError.
    """
    try:
        pose = flange_pose(robot, np.array(message.measured_joint_position, np.float64))
    except ValueError as error:
        raise ConversionError(f'lbr_state: {error}') from error
    return int(message.time_stamp_sec) * 10**9 + int(message.time_stamp_nano_sec), pose


def transform_to_matrix(message: Transform) -> Array:
    """Return the transform (4, 4) [m] of a tf2 transform. Raises ConversionError."""
    t = message.translation
    return pose_to_matrix(Pose(position=Point(x=t.x, y=t.y, z=t.z),
                               orientation=message.rotation))


def pose_to_message(stamp_ns: int, frame_id: str, T_frame_body: Array) -> PoseStamped:
    """Convert a transform (4, 4) [m] to a stamped pose."""
    x, y, z, w = Rotation.from_matrix(T_frame_body[:3, :3]).as_quat().tolist()
    px, py, pz = T_frame_body[:3, 3].tolist()
    return PoseStamped(
        header=Header(stamp=ns_to_stamp(stamp_ns), frame_id=frame_id),
        pose=Pose(position=Point(x=px, y=py, z=pz), orientation=Quaternion(x=x, y=y, z=z, w=w)))
