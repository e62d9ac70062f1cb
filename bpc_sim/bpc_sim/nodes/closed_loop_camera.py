"""The camera of a print whose rate is corrected while it runs: it sees what was really laid.

The ink follows from the published poses of the robot and states of the extruder.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

from geometry_msgs.msg import PoseStamped
import numpy as np
from rclpy.node import Node

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.drivers.cameras import CameraError
from bpc_perception.messages import topics
from bpc_perception.messages.poses.pose import pose_to_matrix
from bpc_perception.messages.stamps import stamp_to_ns
from bpc_sim.closed_loop.job import ClosedLoopJob
from bpc_sim.ink.extrusion import Extrusion
from bpc_sim.scene.render import render
from bpc_sim.scene.scene import Scene

LONGEST_STEP_M = 0.5e-3  # between poses; a longer one may cut a corner
POSE_HISTORY_S = 2.0  # so that an acquisition can have begun in the past


@dataclass(frozen=True, eq=False)
class _RobotPose:
    """Where the robot was at a time.

    Attributes:
        time: stamp of the pose [s].
        s: arc length that the nozzle had reached [m].
        T_base_flange: (4, 4) pose of the flange.
    """

    time: float
    s: float
    T_base_flange: Array


class ClosedLoopCamera:
    """A camera that sees ink and nozzle as they were when the acquisition began."""

    def __init__(self, node: Node, print_: ClosedLoopJob) -> None:
        self._print = print_
        self._extrusion = Extrusion(print_.situation.behaviour, print_.job.length)
        self._flow = 0.0
        self._s = 0.0
        self._began = self._joined = False
        self._tip = np.zeros(3)
        self._poses: deque[_RobotPose] = deque()
        self._number = 0
        self._node = node
        self._subscriptions = [
            node.create_subscription(kind, topic, take, topics.EXTRUSION_QOS)
            for kind, topic, take in ((ExtrusionState, topics.EXTRUSION, self._on_extruder),
                                      (PoseStamped, topics.POSE, self._on_pose))]

    def _on_extruder(self, message: ExtrusionState) -> None:
        self._flow = message.flow_rate if message.extruding else 0.0
        self._began |= bool(message.extruding)

    def _on_pose(self, message: PoseStamped) -> None:
        time, pose = stamp_to_ns(message.header.stamp) * 1e-9, pose_to_matrix(message.pose)
        tip = self._print.tip(pose)
        if self._began and not self._joined:
            self._joined, self._s = True, self._print.nearest(tip)
        elif self._began:
            step = float(np.linalg.norm(tip - self._tip))
            # Between two poses the path is straight enough, unless the robot was held up.
            there = self._s + step if step < LONGEST_STEP_M else self._print.nearest(tip)
            self._s = min(max(there, self._s), self._print.job.length)
            self._extrusion.advance(time, self._s, self._flow)
        self._tip = tip
        self._poses.append(_RobotPose(time, self._s, pose))
        while time - self._poses[0].time > POSE_HISTORY_S:
            self._poses.popleft()

    def connect(self) -> None:
        """Do nothing: the camera is always there."""

    def due(self, now_ns: int) -> bool:
        """Return False: captures are taken on request only."""
        del now_ns
        return False

    def capture(self, now_ns: int) -> Capture:
        """Return the capture whose acquisition ends now.

        Raises:
            CameraError: the pose at the beginning is not known, or the situation has lost the
                camera.
        """
        situation, job = self._print.situation, self._print.job
        began = now_ns * 1e-9 - situation.acquisition
        if self._began and self._poses[-1].time < began:
            raise CameraError('capture: expected the pose of the robot at its beginning, found '
                              f'the newest {began - self._poses[-1].time:.1f} s older')
        before = [pose for pose in self._poses if pose.time <= began]
        if not before:
            raise CameraError('capture: expected the robot to publish its pose, found none')
        if self._s >= situation.camera_lost:
            raise CameraError('capture: expected the camera to answer, found it lost')
        newest = before[-1]
        T_flange_tip = np.eye(4)
        T_flange_tip[:3, 3] = job.nozzle_offset
        scene = Scene(self._print.deposit(self._extrusion, newest.s), job.T_base_surface,
                      newest.T_base_flange @ T_flange_tip, job.nozzle)
        self._number += 1
        return render(scene, job.view, job.sensor,
                      np.random.default_rng((situation.seed, self._number)), now_ns)

    def notes(self) -> Mapping[str, object]:
        """Return no notes."""
        return {}

    def close(self) -> None:
        """Stop listening to robot and extruder."""
        while self._subscriptions:
            self._node.destroy_subscription(self._subscriptions.pop())
