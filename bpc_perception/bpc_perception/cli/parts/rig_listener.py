"""Listens to the topics of a rig for a while, before a print."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
import struct
import time
from typing import Any

import numpy as np
from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Image

from bpc_perception.cli.parts.preflight import (
    FAIL,
    Finding,
    Heard,
    judge_exposure,
    judge_extruder,
    judge_frames,
    judge_stamps,
    judge_topic,
)
from bpc_perception.core.capture.exposure import Exposure
from bpc_perception.core.config import RecorderConfig
from bpc_perception.core.extruder.tic import error_names
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.display.units import NS_PER_S, S_PER_NS
from bpc_perception.messages import topics
from bpc_perception.messages.capture import image_to_rgb
from bpc_perception.messages.poses.flange_poses import FlangePoses
from bpc_perception.messages.stamps import ConversionError, stamp_to_ns

# A message with a header begins with its stamp, behind 4 bytes of CDR.
DISCOVERY_S = 1.0  # in which topics are found one after the other
PARTS_PATIENCE_S = 2.0  # between the first and the last part of a capture
IMAGE_STEP = 4  # pixels, of which one is looked at
STAMP_OFFSET_BYTES, STAMP_FORMAT = 4, '<iI'


class RigListener:
    """Hears what the rig publishes.

    Args:
        node: that listens.
        recorder: settings of the path recorder, which say where the poses come from.
        others: topic to the other that is listened to in its place.
        camera: whether the camera publishes already.
        calibration: of the camera, if it is to fit to what is heard.
    """

    def __init__(self, node: Node, recorder: RecorderConfig, others: dict[str, str],
                 camera: bool = True, calibration: HandEye | None = None) -> None:
        self._node = node
        self._calibration = calibration
        self._base_frame = recorder.base_frame
        self._others = others
        self._poses = FlangePoses(recorder.pose, recorder.base_frame)
        self._poses_have_stamps = recorder.pose.source != 'pose'
        self._extruder: Any = None  # the newest message
        self._image = b''  # the newest message
        self._heard: list[Heard] = []
        for name, kind in topics.CAMERA.items() if camera else ():
            # Take it as bytes: a cloud may have 37 MB.
            self._listen(name, 'camera', kind, topics.CAMERA_QOS, self._on_capture, raw=True)
        if recorder.pose.source != 'tf':
            self._listen(self._poses.topic, 'pose', self._poses.message_class, topics.POSE_QOS,
                         self._on_pose)
        self._since = time.monotonic()
        self._listen(topics.EXTRUSION, 'extruder', topics.PRINT[topics.EXTRUSION],
                     topics.EXTRUSION_QOS, self._on_extruder)

    def _listen(self, name: str, kind: str, message_class: Any, qos: Any, on_message: Any,
                raw: bool = False) -> None:
        topic = self._others.get(name, name)
        heard = Heard(self._node.resolve_topic_name(topic), kind, topics.type_name(message_class))
        self._heard.append(heard)
        self._node.create_subscription(
            message_class, topic, partial(on_message, heard), qos, raw=raw)

    def _on_capture(self, heard: Heard, message: bytes) -> None:
        now_ns = _note_arrival(heard)
        seconds, nanoseconds = struct.unpack_from(STAMP_FORMAT, message, STAMP_OFFSET_BYTES)
        stamp_ns = seconds * NS_PER_S + nanoseconds
        heard.stamps.append(stamp_ns)
        heard.delays.append((now_ns - stamp_ns) * S_PER_NS)
        if heard.wanted == topics.type_name(Image):
            self._image = message

    def _on_pose(self, heard: Heard, message: Any) -> None:
        if not self._poses.concerns(message):
            return
        now_ns = _note_arrival(heard)
        stamp = getattr(getattr(message, 'header', None), 'stamp', None)
        stamp_ns = None if stamp is None else stamp_to_ns(stamp)
        try:
            stamp_ns, _ = self._poses.read(message, now_ns)
        except ConversionError as error:  # its clock can be judged all the same
            heard.problems.append(str(error))
        if self._poses_have_stamps and stamp_ns:
            heard.delays.append((now_ns - stamp_ns) * S_PER_NS)

    def _on_extruder(self, heard: Heard, message: Any) -> None:
        now_ns = _note_arrival(heard)
        self._extruder = message
        stamp = message.header.stamp
        heard.delays.append((now_ns - stamp.sec * NS_PER_S - stamp.nanosec) * S_PER_NS)

    def _note_lost_captures(self) -> None:
        """Note of which captures a part did not come, though another did."""
        camera = [heard for heard in self._heard if heard.kind == 'camera']
        since, until = self._since + DISCOVERY_S, time.monotonic() - PARTS_PATIENCE_S
        due = {stamp for heard in camera
               for stamp, at in zip(heard.stamps, heard.arrivals, strict=True)
               if since <= at <= until}
        most = max((len(heard.stamps) for heard in camera), default=0)
        for heard in camera:
            # Of what came as often as the others nothing is lost, whatever its stamps.
            lost = due - set(heard.stamps) if len(heard.stamps) < most else set()
            heard.due, heard.lost = len(due), lost

    def findings(self) -> Iterator[Finding]:
        """Yield what is good or bad about the topics."""
        self._note_lost_captures()
        for heard in self._heard:
            publishers = self._node.get_publishers_info_by_topic(heard.topic)
            heard.publishers = len(publishers)
            heard.types = sorted({publisher.topic_type for publisher in publishers})
            heard.best_effort = any(
                publisher.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
                for publisher in publishers)
            yield from judge_topic(heard)
        if self._image:
            image = deserialize_message(self._image, Image)
            yield _judge_image(image)
            if self._calibration is not None:
                yield from judge_frames(self._calibration.contradiction(
                    self._base_frame, image.header.frame_id))
        yield from judge_stamps([heard.stamps for heard in self._heard if heard.kind == 'camera'])
        if self._extruder is not None:
            yield from judge_extruder(error_names(self._extruder.error_status),
                                      bool(self._extruder.position_uncertain),
                                      bool(np.isfinite(self._extruder.plunger_velocity)),
                                      bool(np.isfinite(self._extruder.flow_rate)))


def _judge_image(message: Image) -> Finding:
    """Judge how an image is exposed, if it is one that can be read."""
    try:
        image = image_to_rgb(message)
    except ConversionError as error:
        return Finding(FAIL, 'exposure', str(error), 'let the camera publish one of these')
    return judge_exposure(Exposure.of(image[::IMAGE_STEP, ::IMAGE_STEP]))


def _note_arrival(heard: Heard) -> int:
    """Note that a message came; return when, by the clock of stamps [ns]."""
    now_ns = time.time_ns()
    heard.arrivals.append(time.monotonic())
    return now_ns
