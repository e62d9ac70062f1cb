"""Fuzz targets: messages and captures, as the nodes take them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseStamped
import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CameraInfo, Image, JointState, PointCloud2
from std_msgs.msg import String

from bpc_interfaces.msg import (
    DepositionPath as DepositionPathMsg,
    ExtrusionState,
    RateAdvice,
    ThicknessProfile,
    ThicknessProfileUpdate,
)
from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.path.tracker import PrintTracker
from bpc_perception.core.profile import Status
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.core.session import Session
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.capture_pairing import CapturePairer
from bpc_perception.messages.extruder import extruder_from_message, joint_motion
from bpc_perception.messages.path import path_from_message
from bpc_perception.messages.poses.pose import joints_to_matrix, pose_to_matrix
from bpc_perception.messages.profile import (
    change_from_message,
    profile_from_message,
    profile_to_message,
)
from bpc_perception.messages.results.advice import advice_from_message
from bpc_perception.messages.stamps import ConversionError
from bpc_system_tests.robustness.fuzz_targets.sample_messages import (
    recorded_messages,
    small_capture,
    straight_path,
)

# The first byte of an input chooses the kind of its message.
KINDS = (Image, CameraInfo, PointCloud2, PoseStamped, JointState, ExtrusionState,
         DepositionPathMsg, ThicknessProfile, RateAdvice, String, ThicknessProfileUpdate)
LENGTH_BYTES = 4  # in front of each message of a capture


def serialized(message: Any) -> bytes:
    """Return the number of the kind, and the message."""
    return bytes((KINDS.index(type(message)),)) + bytes(serialize_message(message))


def deserialized(data: bytes) -> Any:
    """Return the message in the bytes; None where the middleware would drop it."""
    try:
        return deserialize_message(data[1:], KINDS[data[0] % len(KINDS)])
    except Exception:  # the type support may raise anything
        return None


def message_seeds() -> list[bytes]:
    """Return one message of each kind."""
    session = measured_session()
    result, = session.results(finish=True)
    assert result.profile is not None
    assert (result.profile.status == Status.MEASURED).any()
    return [serialized(message) for message in (
        *(message for _, message in recorded_messages()),
        profile_to_message(result.profile, 'base'),
        RateAdvice(flow_rate_scale=1.0, speed_scale=1.0))]


def measured_session() -> Session:
    """Return a session with a path and a capture that can be measured."""
    session = empty_session()
    session.add_capture(small_capture())
    return session


def empty_session() -> Session:
    """Return a session with a path and no capture."""
    session = Session(ThicknessConfig(), HandEye(True, np.eye(4)))
    session.set_path(straight_path())
    return session


def take_pose(message: PoseStamped) -> object:
    """Do what the path recorder does with a pose."""
    matrix = pose_to_matrix(message.pose)
    return PrintTracker(RecorderConfig().path).add_pose(0, matrix[:3, 3])


def take_joints(message: JointState) -> object:
    """Do what path recorder and extruder bridge do with joint states."""
    joints_to_matrix(message, 'lbr_med_7')
    return joint_motion(message, 'lbr_A1')


def take_extrusion(message: ExtrusionState) -> object:
    """Do what the path recorder does with a state of the extruder."""
    return PrintTracker(RecorderConfig().path).add_extruder(extruder_from_message(message))


# All that the nodes do with a message, except the measurement.
TAKERS: dict[type[Any], Callable[[Any], object]] = {
    PoseStamped: take_pose, JointState: take_joints, ExtrusionState: take_extrusion,
    DepositionPathMsg: path_from_message, ThicknessProfile: profile_from_message,
    ThicknessProfileUpdate: change_from_message, RateAdvice: advice_from_message}


def read_message(data: bytes) -> object:
    """Take a message as the nodes do."""
    message = deserialized(data) if data else None
    take = TAKERS.get(type(message))
    return take(message) if take is not None else None


def capture_seeds() -> list[bytes]:
    """Return the three messages of a capture, each with its length in front."""
    parts = [serialized(message) for message in capture_to_messages(small_capture())]
    return [b''.join(len(part).to_bytes(LENGTH_BYTES, 'little') + part for part in parts)]


def measure_capture(data: bytes) -> object:
    """Do all that the thickness node does with a capture.

    Raises:
        AssertionError: the session met an error that it does not expect.
    """
    session, pairer = empty_session(), CapturePairer()
    names = dict(zip((Image, CameraInfo, PointCloud2), topics.CAMERA, strict=True))
    for message in capture_messages(data):
        if type(message) not in names:
            continue
        try:
            capture = pairer.add(names[type(message)], message)
        except ConversionError:
            continue
        if capture is not None:
            session.add_capture(capture)
    for result in session.results(finish=True):
        # The session reports an unexpected error in these words.
        assert not result.refusal.startswith('measurement: expected a result'), result.refusal
        if result.profile is not None:
            serialize_message(profile_to_message(result.profile, 'base'))
    return None


def capture_messages(data: bytes) -> list[Any]:
    """Return the messages of an input, in order; None for one that cannot be read."""
    messages = []
    while data:
        end = LENGTH_BYTES + int.from_bytes(data[:LENGTH_BYTES], 'little')
        messages.append(deserialized(data[LENGTH_BYTES:end] or b'\0'))
        data = data[end:]
    return messages
