"""Faults of camera, robot and extruder, as changes of good messages."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
import math
from typing import Any

from geometry_msgs.msg import PoseStamped
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Image, PointCloud2, PointField
from std_msgs.msg import Header

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.display.units import NS_PER_S
from bpc_perception.messages import topics
from bpc_system_tests.parts.spoiled_captures import CHANGES, Messages

PADDING_BYTES = 64  # added to each row


@dataclass(frozen=True)
class CameraFault:
    """A change of a good capture.

    Attributes:
        change: changes its messages.
        most: how many captures a receiver may count at most; it counts at least one.
    """

    change: Callable[[Messages], None]
    most: int = 1


def shifted(seconds: float) -> Callable[[Messages], None]:
    """Shift the stamps of all three messages by a time [s]."""
    def change(messages: Messages) -> None:
        for message in messages.values():
            stamp_ns = message.header.stamp.sec * NS_PER_S + message.header.stamp.nanosec
            stamp_ns += round(seconds * NS_PER_S)
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, NS_PER_S)
    return change


def without(name: str) -> Callable[[Messages], None]:
    """Leave one of the three messages out."""
    def change(messages: Messages) -> None:
        del messages[name]
    return change


def cloud_of_another_stamp(messages: Messages) -> None:
    messages[topics.CLOUD].header.stamp.sec -= 1


def no_pixels(messages: Messages) -> None:
    for message in messages.values():
        message.width = message.height = 0
    for name in (topics.IMAGE, topics.CLOUD):
        messages[name].data = array('B')


def truncated_cloud(messages: Messages) -> None:
    cloud: PointCloud2 = messages[topics.CLOUD]
    cloud.data = array('B', bytes(cloud.data[:len(cloud.data) // 2]))


def truncated_image(messages: Messages) -> None:
    image: Image = messages[topics.IMAGE]
    image.data = array('B', bytes(image.data[:-1]))


def absurd_size(messages: Messages) -> None:
    for message in messages.values():
        message.width = message.height = 2**32 - 1
    messages[topics.IMAGE].step = messages[topics.CLOUD].row_step = 2**32 - 1


def absurd_point_step(messages: Messages) -> None:
    messages[topics.CLOUD].point_step = 2**32 - 1


def another_frame(messages: Messages) -> None:
    for message in messages.values():
        message.header.frame_id = 'nowhere'


def _points(cloud: PointCloud2) -> NDArray[np.float32]:
    return np.ndarray((cloud.height, cloud.width, 4), '<f4', cloud.data)


def big_endian(messages: Messages) -> None:
    cloud: PointCloud2 = messages[topics.CLOUD]
    cloud.data = array('B', _points(cloud).astype('>f4').tobytes())
    cloud.is_bigendian = True


def padded_rows(messages: Messages) -> None:
    for name, step in ((topics.IMAGE, 'step'), (topics.CLOUD, 'row_step')):
        message = messages[name]
        old = getattr(message, step)
        rows = np.frombuffer(message.data, np.uint8).reshape(message.height, old)
        setattr(message, step, old + PADDING_BYTES)
        message.data = array('B', np.pad(rows, ((0, 0), (0, PADDING_BYTES))).tobytes())


def other_field_order(messages: Messages) -> None:
    cloud: PointCloud2 = messages[topics.CLOUD]
    points = np.zeros((cloud.height, cloud.width, 5), '<f4')
    points[..., [2, 1, 4, 0]] = _points(cloud)
    cloud.point_step, cloud.row_step = 20, 20 * cloud.width
    cloud.fields = [PointField(name=name, offset=4 * index, count=1, datatype=PointField.FLOAT32)
                    for name, index in (('rgba', 0), ('y', 1), ('x', 2), ('z', 4))]
    cloud.data = array('B', points.tobytes())


CAMERA_FAULTS: dict[str, CameraFault] = {
    **{name: CameraFault(change) for name, (change, _) in CHANGES.items()},
    'without image': CameraFault(without(topics.IMAGE)),
    'without camera info': CameraFault(without(topics.CAMERA_INFO)),
    'cloud of another stamp': CameraFault(cloud_of_another_stamp, 2),
    'no pixels': CameraFault(no_pixels),
    'truncated cloud': CameraFault(truncated_cloud),
    'truncated image': CameraFault(truncated_image),
    'absurd size': CameraFault(absurd_size),
    'absurd point step': CameraFault(absurd_point_step),
    'another frame': CameraFault(another_frame),
    'stamp of the future': CameraFault(shifted(30.0)),
    # With these the camera info may be given up before image and cloud arrive.
    'stamp of the past': CameraFault(shifted(-5.0), 2),
    'stamp of long ago': CameraFault(shifted(-1e6), 2),
    'big endian': CameraFault(big_endian),
    'padded rows': CameraFault(padded_rows),
    'other field order': CameraFault(other_field_order),
}


def spoiled(good: Messages, fault: CameraFault, stamp: Any) -> Messages:
    """Return what is sent in place of a good capture; large arrays are shared with it."""
    changed = stamped(good, stamp)
    fault.change(changed)
    return changed


def stamped(good: Messages, stamp: Any) -> Messages:
    """Return copies of the messages with a new stamp; large arrays are shared."""
    changed = {name: copy(message) for name, message in good.items()}
    for message in changed.values():
        message.header = Header(stamp=copy(stamp), frame_id=message.header.frame_id)
    return changed


def jump(pose: PoseStamped) -> None:
    pose.pose.position.x += 0.1


def not_a_number(pose: PoseStamped) -> None:
    pose.pose.position.y = math.nan


def zero_quaternion(pose: PoseStamped) -> None:
    for axis in 'xyzw':
        setattr(pose.pose.orientation, axis, 0.0)


def back_in_time(pose: PoseStamped) -> None:
    pose.header.stamp.sec -= 1


def frame_of_another(pose: PoseStamped) -> None:
    pose.header.frame_id = 'nowhere'


POSE_FAULTS: dict[str, Callable[[PoseStamped], None]] = {
    'jump': jump, 'NaN': not_a_number, 'zero quaternion': zero_quaternion,
    'back in time': back_in_time, 'frame of another': frame_of_another}


def motor_error(state: ExtrusionState) -> None:
    state.error_status, state.extruding = 1 << 2, False
    state.plunger_velocity = state.flow_rate = math.nan


def uncertain(state: ExtrusionState) -> None:
    state.position_uncertain = True


def unknown_rates(state: ExtrusionState) -> None:
    state.plunger_velocity = state.flow_rate = math.inf


EXTRUDER_FAULTS: dict[str, Callable[[ExtrusionState], None]] = {
    'motor error': motor_error, 'position uncertain': uncertain,
    'unknown rates': unknown_rates}
