"""Captures that cannot be measured: good ones with one change."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
import shutil
from typing import Any

import numpy as np
from sensor_msgs.msg import CameraInfo, Image, PointCloud2

from bpc_perception.messages import topics
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.bag_writer import BagWriter
from bpc_system_tests.parts.command_line import SAMPLE

# The messages of a capture by topic; a change may remove one.
Messages = dict[str, Any]
Change = Callable[[Messages], None]


def without_cloud(messages: Messages) -> None:
    del messages[topics.CLOUD]


def cloud_of_another_size(messages: Messages) -> None:
    cloud: PointCloud2 = messages[topics.CLOUD]
    cloud.height -= 1
    cloud.data = cloud.data[:cloud.height * cloud.row_step]


def unorganized_cloud(messages: Messages) -> None:
    cloud: PointCloud2 = messages[topics.CLOUD]
    image: Image = messages[topics.IMAGE]
    info: CameraInfo = messages[topics.CAMERA_INFO]
    cloud.width, cloud.height = cloud.width * cloud.height, 1
    cloud.row_step = cloud.width * cloud.point_step
    # The image gets the same size, so that the size is not what differs.
    image.width, image.height, image.step = cloud.width, 1, cloud.width * 4
    info.width, info.height = cloud.width, 1


def cloud_without_points(messages: Messages) -> None:
    cloud: PointCloud2 = messages[topics.CLOUD]
    cloud.data = array('B', np.full(len(cloud.data) // 4, np.nan, np.float32).tobytes())


def unknown_encoding(messages: Messages) -> None:
    messages[topics.IMAGE].encoding = 'bayer_rggb8'


def uncalibrated_camera(messages: Messages) -> None:
    messages[topics.CAMERA_INFO].k = np.zeros(9)


# Each change, and the words that the refusal has to contain.
CHANGES: dict[str, tuple[Change, list[str]]] = {
    'without cloud': (without_cloud, [
        'expected color/image_color, color/camera_info, points/xyzrgba of one stamp',
        'found no points/xyzrgba']),
    'cloud of another size': (cloud_of_another_size, [
        'expected one size for image, camera_info and cloud',
        'found 304 x 228, 304 x 228, 304 x 227']),
    'unorganized cloud': (unorganized_cloud, [
        'expected an organized cloud', 'found 69312 x 1 points']),
    'cloud without points': (cloud_without_points, [
        'expected points around the path', 'found 0 where']),
    'unknown encoding': (unknown_encoding, [
        'expected encoding rgba8, rgb8, bgr8, bgra8', 'found "bayer_rggb8"']),
    'uncalibrated camera': (uncalibrated_camera, ['expected a calibrated camera', 'found K']),
}


def captures(bag: Path) -> list[Messages]:
    """Return the messages of each capture of a recording, by relative topic."""
    found: dict[int, Messages] = {}
    for topic, log_ns, message in Bag(bag).messages({f'/{name}' for name in topics.CAMERA}):
        found.setdefault(log_ns, {})[topic.lstrip('/')] = message
    return list(found.values())


def spoil(messages: Messages, change: Change) -> Messages:
    """Return a changed copy of a capture."""
    changed = deepcopy(messages)
    change(changed)
    return changed


def write_spoiled(source: Path, target: Path, change: Change | None = None,
                  leave_out: frozenset[str] = frozenset()) -> Path:
    """Write a copy of a recording with every capture changed, or without some topics."""
    bag = Bag(source)
    with BagWriter(target, compress=True) as writer:
        for topic, type_name in bag.topics.items():
            if topic not in leave_out:
                writer.add_topic(topic, type_name)
        capture: Messages = {}  # as far as its messages have come
        for topic, log_ns, message in bag.messages(set(bag.topics) - leave_out):
            name = topic.lstrip('/')
            if name not in topics.CAMERA or change is None:
                writer.write(topic, log_ns, message)
                continue
            capture[name] = message
            if len(capture) == len(topics.CAMERA):
                change(capture)
                for changed, part in capture.items():
                    writer.write(f'/{changed}', log_ns, part)
                capture = {}
    for name in ('hand_eye.calib', 'params.yaml'):
        shutil.copy(SAMPLE / name, target)
    return target
