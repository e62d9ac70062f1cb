"""``bpc check``: what is there and what is missing, before a print."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
import os
from pathlib import Path
import shutil
import struct
import time
from typing import Annotated, Any

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy
import typer

from bpc_perception.cli.parts.options import JsonOption, QuietOption, RemapOption, remappings
from bpc_perception.cli.parts.preflight import (
    FAIL,
    Finding,
    Heard,
    judge_calibration,
    judge_disk,
    judge_extruder,
    judge_target,
    judge_topic,
    judge_transport,
    OK,
)
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.extruder.tic import error_names
from bpc_perception.core.parameter import ConfigError
from bpc_perception.drivers import check_back_end
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.files.parameter_file import configure, live_recorder
from bpc_perception.messages import topics
from bpc_perception.messages.flange_poses import FlangePoses
from bpc_perception.messages.stamps import ConversionError

DAY = 86400.0  # [s]


class Listener:
    """Hears what the rig publishes for a while; of the camera only where it publishes already."""

    def __init__(self, node: Node, recorder: RecorderConfig, others: dict[str, str],
                 camera: bool = True) -> None:
        self._node = node
        self._poses = FlangePoses(recorder.pose, recorder.base_frame)
        self._timed = recorder.pose.source != 'pose'
        self.extruder: Any = None
        self.heard: list[Heard] = []
        for name, kind in topics.CAMERA.items() if camera else ():
            # Not taken apart: a cloud may have 37 MB.
            self._listen(others.get(name, name), 'camera', kind, topics.CAMERA_QOS, raw=True)
        if recorder.pose.source != 'tf':
            name = self._poses.topic
            self._listen(others.get(name, name), 'pose', self._poses.message_class,
                         topics.POSE_QOS)
        name = topics.EXTRUSION
        self._listen(others.get(name, name), 'extruder', topics.PRINT[name], topics.EXTRUSION_QOS)

    def _listen(self, topic: str, kind: str, message_class: Any, qos: Any,
                raw: bool = False) -> None:
        heard = Heard(self._node.resolve_topic_name(topic), kind, topics.type_name(message_class))
        self.heard.append(heard)
        self._node.create_subscription(
            message_class, topic, partial(self._on_message, heard), qos, raw=raw)

    def _on_message(self, heard: Heard, message: Any) -> None:
        now_ns = time.time_ns()
        heard.arrivals.append(time.monotonic())
        if heard.kind == 'camera':
            # The stamp is what a message with a header begins with, after 4 bytes of CDR.
            seconds, nanoseconds = struct.unpack_from('<iI', message, 4)
            heard.delays.append((now_ns - seconds * 10**9 - nanoseconds) * 1e-9)
        elif heard.kind == 'pose':
            try:
                stamp_ns, _ = self._poses.read(message, now_ns)
            except ConversionError as error:
                heard.problems.append(str(error))
                return
            if self._timed:
                heard.delays.append((now_ns - stamp_ns) * 1e-9)
        else:
            self.extruder = message
            stamp = message.header.stamp
            heard.delays.append((now_ns - stamp.sec * 10**9 - stamp.nanosec) * 1e-9)

    def findings(self) -> Iterator[Finding]:
        """What is good or bad about the topics."""
        for heard in self.heard:
            found = self._node.get_publishers_info_by_topic(heard.topic)
            heard.publishers = len(found)
            heard.types = sorted({each.topic_type for each in found})
            heard.best_effort = any(
                each.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT for each in found)
            yield from judge_topic(heard)
        if self.extruder is not None:
            yield from judge_extruder(error_names(self.extruder.error_status),
                                      bool(self.extruder.position_uncertain),
                                      bool(np.isfinite(self.extruder.plunger_velocity)),
                                      bool(np.isfinite(self.extruder.flow_rate)))


def check(
    hand_eye: Annotated[Path, typer.Option(
        '--handeye', metavar='FILE', help='Hand-eye calibration.')],
    parameters: Annotated[Path | None, typer.Option(
        '--params', metavar='FILE', help='ROS parameter file for the nodes.')] = None,
    camera: Annotated[str | None, typer.Option(
        '--camera', metavar='BACK_END', help='live is going to take captures with this back end '
        'of the camera driver, so nobody publishes them yet; unless given, the camera '
        'publishes.')] = None,
    remap: RemapOption = None,
    seconds: Annotated[float, typer.Option(help='How long to listen.')] = 5.0,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Ask before a print what is there; OK, WARN or FAIL for each, and what to do.

    The exit status is 1 if something fails.
    """
    terminal = Terminal(quiet, json_lines)
    others = remappings(remap)
    if camera is not None:
        check_back_end(camera)
    found = list(_settings(hand_eye, parameters))
    shared_memory = shutil.disk_usage('/dev/shm').free  # noqa: S108 (no file is made there)
    found += judge_transport(os.environ, shared_memory)
    found.append(judge_disk(str(Path.cwd()), shutil.disk_usage(Path.cwd()).free))
    for finding in found:
        _show(finding, terminal)
    rclpy.init(args=[])  # the command's own have := in them too
    node = rclpy.create_node('bpc_check')
    try:
        listener = Listener(node, configure(RecorderConfig(), 'path_recorder', parameters), others,
                            camera is None)
        executor = SingleThreadedExecutor()  # rclpy.spin_once() is too slow for fast streams
        executor.add_node(node)
        start = time.monotonic()
        with terminal.progress('listen', round(seconds)) as advance:
            while (passed := time.monotonic() - start) < seconds:
                executor.spin_once(timeout_sec=0.05)
                advance(int(passed), round(seconds))
        for finding in listener.findings():
            _show(finding, terminal)
            found.append(finding)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    failed = sum(finding.level == FAIL for finding in found)
    if failed:
        terminal.tell('failed', f'{failed} of {len(found)} fail', failed=failed, of=len(found))
        raise typer.Exit(1)


def _settings(hand_eye: Path, parameters: Path | None) -> Iterator[Finding]:
    calibration = load_hand_eye(hand_eye)
    age = (time.time() - hand_eye.stat().st_mtime) / DAY
    yield judge_calibration('eye_on_base' if calibration.on_base else 'eye_in_hand', age)
    advice = configure(ThicknessConfig(), 'thickness', parameters).advice
    yield judge_target(advice.target_thickness, advice.target_file)
    try:
        offset = live_recorder(parameters).nozzle_offset
    except ConfigError as error:
        yield Finding(FAIL, 'nozzle offset', 'none', str(error))
        return
    yield Finding(OK, 'nozzle offset',
                  ', '.join(f'{value * 1e3:.2f}' for value in offset) + ' mm')


def _show(finding: Finding, terminal: Terminal) -> None:
    todo = f'; {finding.todo}' if finding.todo else ''
    terminal.tell('finding', f'{finding.level:4} {finding.subject}: {finding.found}{todo}',
                  **finding._asdict())
