"""The results writer: keeps files and report of each print that is measured, while it grows."""

from __future__ import annotations

from functools import partial
from pathlib import Path
import time
from typing import Any

import numpy as np
from rcl_interfaces.msg import ParameterEvent
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import qos_profile_parameter_events, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image

from bpc_interfaces.msg import PrintVerdict, RateAdvice, RepairPlan
from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import PinholeCamera
from bpc_perception.core.config import RecorderConfig, ResultsWriterConfig, ThicknessConfig
from bpc_perception.core.parameter import ConfigError, flatten, replace_flat
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.result import Result
from bpc_perception.core.robot.poses import PoseBuffer
from bpc_perception.files.design.wanted import wanted_design
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.files.parameter_file import configure
from bpc_perception.messages import topics
from bpc_perception.messages.capture import camera_from_info, image_to_rgb
from bpc_perception.messages.results.advice import advice_from_message
from bpc_perception.messages.results.repair import repair_from_message
from bpc_perception.messages.results.verdict import verdict_from_message
from bpc_perception.messages.stamps import ConversionError, stamp_to_ns
from bpc_perception.nodes.parts.pose_source import subscribe_poses
from bpc_perception.nodes.parts.profile_follower import ProfileFollower
from bpc_perception.recording.print_folder import RECORDING
from bpc_perception.report.live_results import LiveResults, seen
from bpc_perception.report.provenance import live_provenance
from bpc_perception.runtime.clock import steady_clock
from bpc_perception.runtime.diagnostics import Diagnostics, in_words
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.process import limit_cpu_use
from bpc_perception.runtime.run import run

# Images that may wait for their profile, or for a report that is being written; and the others.
MOST_WAITING = 20
UNDER_WAY_S = 0.5  # after the last result, when the writer is to end
MOST_UNDER_WAY_S = 5.0  # for all of them, where the measuring goes on
IMAGE_QOS = QoSProfile(depth=MOST_WAITING, reliability=ReliabilityPolicy.RELIABLE)


class ResultsWriterNode(Node):
    """Writes profile.csv, summary.json and report.html; see docs/reference/nodes."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('results_writer', **kwargs)
        self._config = config = NodeConfig(self, ResultsWriterConfig()).value
        limit_cpu_use(config.process, self.get_logger())
        self._hand_eye = load_hand_eye(config.hand_eye_file)
        file = config.parameter_file or None
        self._thickness = configure(ThicknessConfig(), 'thickness', file)
        self._recorder = configure(RecorderConfig(), 'path_recorder', file)
        self._results = LiveResults(
            Path(config.prints), wanted_design(self._thickness.design, config.design_file))
        # When files were written, and a result came, last [s], steady.
        self._written = self._heard = -np.inf
        # What came of each capture, by its stamp [ns], until all of it is there.
        self._images: dict[int, Image] = {}
        self._profiles: dict[int, ThicknessProfile] = {}
        self._advice: dict[int, RateAdvice] = {}
        self._verdicts: dict[int, PrintVerdict] = {}
        self._repairs: dict[int, RepairPlan] = {}
        self._camera: PinholeCamera | None = None
        self._poses = PoseBuffer()
        self._diagnostics = Diagnostics(self)
        for kind, topic, qos, waiting in (
                (Image, topics.IMAGE, IMAGE_QOS, self._images),
                (RateAdvice, topics.ADVICE, topics.RESULT_QOS, self._advice),
                (PrintVerdict, topics.VERDICT, topics.RESULT_QOS, self._verdicts),
                (RepairPlan, topics.REPAIR, topics.RESULT_QOS, self._repairs)):
            self.create_subscription(kind, topic, partial(self._on_message, waiting), qos)
        ProfileFollower(self, self._on_profile, self._diagnostics.refuse)
        self.create_subscription(CameraInfo, topics.CAMERA_INFO, self._on_info,
                                 topics.CAMERA_INFO_QOS)
        self.create_subscription(ParameterEvent, '/parameter_events', self._on_parameters,
                                 qos_profile_parameter_events)
        if not self._hand_eye.on_base:
            thickness = self._thickness
            subscribe_poses(self, thickness.pose, thickness.base_frame,
                            thickness.watch.maximum_lead, self._diagnostics, self._on_pose)
        self._timer = self.create_timer(config.period / 10, self._write_in_time,
                                        clock=steady_clock())

    def _on_message(self, waiting: dict[int, Any], message: Any) -> None:
        self._on_part(waiting, stamp_to_ns(message.header.stamp), message)

    def _on_profile(self, profile: ThicknessProfile) -> None:
        self._on_part(self._profiles, profile.stamp_ns, profile)

    def _on_part(self, waiting: dict[int, Any], stamp_ns: int, part: Any) -> None:
        waiting[stamp_ns] = part
        if waiting is not self._images:
            self._heard = time.monotonic()
        if len(waiting) > MOST_WAITING:
            del waiting[next(iter(waiting))]
        self._take()

    def _on_info(self, message: CameraInfo) -> None:
        try:
            self._camera = camera_from_info(message)
        except ConversionError as error:
            self._diagnostics.refuse(error)

    def _on_pose(self, stamp_ns: int, T_base_flange: Array) -> None:
        self._poses.add(stamp_ns, T_base_flange)

    def _on_parameters(self, message: ParameterEvent) -> None:
        """Follow what the thickness node is told while it runs."""
        if message.node.rpartition('/')[2] != 'thickness':
            return
        known = {name for name, _, _ in flatten(self._thickness)}
        values = {parameter.name: parameter_value_to_python(parameter.value)
                  for parameter in (*message.new_parameters, *message.changed_parameters)
                  if parameter.name in known}
        try:
            self._thickness = replace_flat(self._thickness, values)
        except ConfigError as error:
            self._diagnostics.refuse(error)

    def _take(self) -> None:
        """Take the results whose profile, advice and image have come."""
        all_parts = self._images, self._profiles, self._advice, self._verdicts, self._repairs
        for stamp_ns in sorted(set.intersection(*map(set, all_parts))):
            if self._camera is None:
                return
            try:
                self._add(stamp_ns, self._camera)
            except (ValueError, MemoryError) as error:  # also what does not convert
                self._diagnostics.refuse(in_words(error))
            for waiting in all_parts:
                for older in [each for each in waiting if each <= stamp_ns]:
                    del waiting[older]

    def _add(self, stamp_ns: int, camera: PinholeCamera) -> None:
        profile = self._profiles[stamp_ns]
        advice = advice_from_message(self._advice[stamp_ns])
        if self._results.begins_with(profile.print_id):
            self.end()  # of the print before
        capture = seen(stamp_ns, image_to_rgb(self._images[stamp_ns]), camera)
        T_base_camera = self._hand_eye.camera_pose(self._poses, stamp_ns,
                                                   self._thickness.maximum_pose_gap)
        self._results.add(profile, Result(
            capture, T_base_camera, profile, advice,
            verdict_from_message(self._verdicts[stamp_ns]),
            repair=repair_from_message(self._repairs[stamp_ns]),
            warning=profile.off_path(self._thickness.maximum_offset)))
        self._diagnostics.count('results')

    def _write_in_time(self) -> None:
        if time.monotonic() - self._written > self._config.period:
            self.write()

    def write(self) -> None:
        """Write what is new; what was written before stays if that fails."""
        if not self._results.changed:
            return
        try:
            self._results.write(live_provenance(
                self._results.folder / RECORDING, Path(self._config.hand_eye_file),
                self._thickness, self._recorder))
            self._diagnostics.count('times written')
        except (OSError, ValueError, MemoryError) as error:
            self._diagnostics.refuse(f'results: expected to write {self._results.folder}, '
                                     f'found: {in_words(error)}; make room there, or let it be '
                                     'written to')
        self._written = time.monotonic()

    def end(self) -> None:
        """Write what is left of a print of which nothing more comes."""
        if self._results.print_id:
            self._results.end()
            self.write()

    def finish(self) -> None:
        """Take what is still under way, and write it."""
        self._timer.cancel()  # to write takes longer than the last results are waited for
        self._heard = time.monotonic()
        end = self._heard + MOST_UNDER_WAY_S
        executor = SingleThreadedExecutor(context=self.context)
        executor.add_node(self)
        while time.monotonic() < min(self._heard + UNDER_WAY_S, end):
            executor.spin_once(timeout_sec=UNDER_WAY_S / 10)
        self.end()


def main() -> None:
    """Run the node."""
    run(ResultsWriterNode, large_messages=True, complete=ResultsWriterNode.finish)


if __name__ == '__main__':
    main()
