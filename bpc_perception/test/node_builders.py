"""Nodes under test, a peer that talks to them, and what it sends."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
import numpy as np
from perception_builders import band_image, capture_of, PIXEL, pixel_path, SECOND, START_NS
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger

from bpc_interfaces.msg import ExtrusionState, RateAdvice, ThicknessProfile
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.path import path_to_message
from bpc_perception.messages.poses.pose import pose_to_message
from bpc_perception.messages.stamps import ns_to_stamp, stamp_to_ns
from bpc_perception.nodes.path_recorder import PathRecorderNode
from bpc_perception.nodes.thickness import ThicknessNode
from bpc_perception.recording.bag_writer import BagWriter

BASE = 'lbr_link_0'
INPUTS = {**topics.CAMERA, **topics.PRINT, topics.PATH: topics.RESULTS[topics.PATH]}
QOS = {**dict.fromkeys(topics.CAMERA, topics.CAMERA_QOS), topics.POSE: topics.POSE_QOS,
       topics.EXTRUSION: topics.EXTRUSION_QOS, topics.PATH: topics.PATH_QOS}


class Bench:
    """A node under test, and one that talks to it and listens."""

    def __init__(self, graph: Any, kind: Any, **parameters: Any) -> None:
        self.graph = graph
        self.node = graph.make(kind, **parameters)
        self.peer: Node = graph.make(Node, 'peer')
        self.received: dict[str, list[Any]] = defaultdict(list)
        self._publishers: dict[str, Any] = {}
        self.listen('/diagnostics', DiagnosticArray, QoSProfile(depth=100))
        # By itself the node publishes once a second; most tests would have to wait for that.
        self.timer = self.peer.create_timer(0.1, self.node._diagnostics.publish)

    def until(self, condition: Callable[[], Any], timeout: float = 10.0) -> None:
        self.graph.spin_until(condition, timeout)

    def listen(self, topic: str, kind: Any, qos: QoSProfile) -> list[Any]:
        """Return the list of messages that arrive on a topic from now on."""
        received = self.received[topic]
        self.peer.create_subscription(kind, topic, received.append, qos)
        self.until(lambda: self.peer.count_publishers(topic))
        return received

    def send(self, topic: str, *messages: Any, kind: Any = None, qos: Any = None) -> None:
        """Publish, as soon as the node listens."""
        if topic not in self._publishers:
            self._publishers[topic] = self.peer.create_publisher(
                kind or INPUTS[topic], topic, qos or QOS[topic])
        publisher = self._publishers[topic]
        self.until(publisher.get_subscription_count)
        for message in messages:
            publisher.publish(message)

    def send_capture(self, stamp_ns: int,
                     spoil: Callable[[dict[str, Any]], None] | None = None) -> None:
        messages = dict(zip(topics.CAMERA, capture_to_messages(
            capture_of(band_image(), stamp_ns)), strict=True))
        if spoil:
            spoil(messages)
        for name, message in messages.items():
            self.send(name, message)

    def call(self, service: str) -> Trigger.Response:
        client = self.peer.create_client(Trigger, service)
        self.until(client.service_is_ready)
        future = client.call_async(Trigger.Request())
        self.until(future.done)
        return future.result()

    @property
    def statuses(self) -> list[Any]:
        return [status for message in self.received['/diagnostics'] for status in message.status
                if status.name == self.node.get_name()]

    def diagnosed(self, key: str) -> str:
        """The latest value of a diagnostic; empty = none."""
        values = {value.key: value.value for value in self.statuses[-1].values} \
            if self.statuses else {}
        return str(values.get(key, ''))


T_BASE_FLANGE = np.diag((1.0, -1.0, -1.0, 1.0))  # the tool points down
T_BASE_FLANGE[2, 3] = 0.15
NOZZLE = [0.0, 0.0, 0.15]


def flange_pose(time: float, speed: float = 0.01, start_ns: int = START_NS) -> PoseStamped:
    """The flange at a time [s], while the nozzle moves along the x axis at ``speed`` [m/s]."""
    T = T_BASE_FLANGE.copy()
    T[0, 3] = speed * time
    return pose_to_message(start_ns + round(time * SECOND), BASE, T)


def extrusion(time: float, extruding: bool = True, start_ns: int = START_NS) -> ExtrusionState:
    """The extruder at a time [s]."""
    message = ExtrusionState(extruding=extruding, plunger_velocity=1e-4, flow_rate=5e-8)
    message.header.stamp = ns_to_stamp(start_ns + round(time * SECOND))
    return message


def recorder_bench(graph: Any, **parameters: Any) -> Bench:
    """A path recorder that publishes at 50 Hz."""
    return Bench(graph, PathRecorderNode, nozzle_offset=NOZZLE, publish_rate=50.0, **parameters)


def print_line(bench: Bench, start_ns: int = START_NS) -> list[Any]:
    """Print for three seconds; return the paths that the recorder publishes."""
    paths = bench.listen(topics.PATH, topics.RESULTS[topics.PATH], topics.PATH_QOS)
    bench.send(topics.EXTRUSION, *(extrusion(t, start_ns=start_ns)
                                   for t in np.arange(0, 3, 0.1)))
    bench.until(lambda: paths)  # the print has begun
    for times, known in ((np.arange(0, 1.5, 0.05), 1.3), (np.arange(1.5, 3, 0.05), 2.8)):
        bench.send(topics.POSE, *(flange_pose(t, start_ns=start_ns) for t in times))
        bench.until(lambda reached=known: paths[-1].complete_until > reached)
    return paths


CALIBRATION = """\
parameters: {{calibration_type: {mount}}}
transform:
  translation: {{x: 0.0, y: 0.0, z: 0.5}}
  rotation: {{x: 1.0, y: 0.0, z: 0.0, w: 0.0}}
"""
STAMP_NS = START_NS + 10 * SECOND  # of a capture, after the whole bead was laid
BEAD_WIDTH_M = 11 * PIXEL  # of band_image
BEAD_PATH = path_to_message(pixel_path((40, 55), (120, 55), 81), BASE)


def thickness_bench(graph: Any, folder: Path, mount: str = 'eye_on_base',
                    **parameters: Any) -> Bench:
    """A thickness node that looks straight down from 0.5 m above the base frame's origin."""
    file = folder / 'camera.calib'
    file.write_text(CALIBRATION.format(mount=mount))
    bench = Bench(graph, ThicknessNode, hand_eye_file=str(file), **parameters)
    bench.listen(topics.PROFILE, ThicknessProfile, topics.RESULT_QOS)
    bench.listen(topics.ADVICE, RateAdvice, topics.RESULT_QOS)
    return bench


def assert_profile_comes(bench: Bench, stamp_ns: int) -> ThicknessProfile:
    """Wait for the profile; check that it is right and the only one."""
    profiles = bench.received[topics.PROFILE]
    bench.until(lambda: profiles and bench.received[topics.ADVICE])
    profile, = profiles
    assert stamp_to_ns(profile.header.stamp) == stamp_ns
    np.testing.assert_allclose(profile.thickness, BEAD_WIDTH_M, atol=1.01 * PIXEL)
    return profile


def record_captures(folder: Path, count: int = 3) -> str:
    """Record one capture a second; return the path of the recording."""
    path = folder / 'bag'
    with BagWriter(path) as writer:
        for name, kind in topics.CAMERA.items():
            writer.add_topic(f'/{name}', topics.type_name(kind))
        for number in range(count):
            stamp_ns = START_NS + number * SECOND
            for name, message in zip(
                    topics.CAMERA, capture_to_messages(capture_of(band_image(), stamp_ns)),
                    strict=True):
                writer.write(f'/{name}', stamp_ns, message)
    return str(path)
