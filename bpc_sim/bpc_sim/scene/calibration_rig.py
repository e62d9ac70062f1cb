"""A synthetic rig that looks at a calibration board from many sides."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.board import Board
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.geometry import invert
from bpc_sim.scene.board import see_board
from bpc_sim.scene.camera import View, zivid_m70


def _pose(xyz: tuple[float, float, float], angles: tuple[float, float, float]) -> Array:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler('xyz', angles, degrees=True).as_matrix()
    pose[:3, 3] = xyz
    return pose


@dataclass(frozen=True, eq=False)
class CalibrationRig:
    """Camera beside the robot and board on its flange, or the other way round.

    Attributes:
        board: what is looked at.
        on_base: whether the camera stands beside the robot.
        scale: of the camera's full image; 0.5 = 2 x 2 sub-sampling.
        tilt: to which sides the board is turned, at most [degrees].
        robot_noise: standard deviations of the flange's poses as told [m], [rad].
        depth_noise: as of see_board; None = a camera without a cloud.
        seed: of poses and noise.
    """

    board: Board
    on_base: bool
    scale: float = 0.5
    tilt: float = 25.0
    robot_noise: tuple[float, float] = (2e-5, 1e-4)
    depth_noise: float | None = 1e-4
    seed: int = 0
    T_base_camera: Array = field(default_factory=lambda: _pose((0.5, 0.1, 0.8), (170, 5, 30)))
    T_flange_camera: Array = field(
        default_factory=lambda: _pose((0.06, -0.03, 0.09), (5, -8, 90)))
    T_flange_board: Array = field(default_factory=lambda: _pose((0.01, 0.02, 0.05), (3, 4, 20)))
    T_base_board: Array = field(default_factory=lambda: _pose((0.55, 0.0, 0.02), (0, 0, 0)))

    @property
    def T_parent_camera(self) -> Array:
        """What a calibration has to find."""
        return self.T_base_camera if self.on_base else self.T_flange_camera

    def captures(self, count: int, first_ns: int = 0,
                 period_ns: int = 0) -> Iterator[tuple[Array, Capture]]:
        """Yield T_base_flange as the robot tells it, and what the camera sees from there."""
        rng = np.random.default_rng(self.seed)
        size = round(1944 * self.scale), round(1200 * self.scale)
        camera = zivid_m70(*size, self.scale)
        for index in range(count):
            T_camera_board = self._seen_from(rng)
            if self.on_base:
                T_base_camera = self.T_base_camera
                T_base_board = T_base_camera @ T_camera_board
                T_base_flange = T_base_board @ invert(self.T_flange_board)
            else:
                T_base_board = self.T_base_board
                T_base_camera = T_base_board @ invert(T_camera_board)
                T_base_flange = T_base_camera @ invert(self.T_flange_camera)
            capture = see_board(self.board, T_base_board, View(camera, T_base_camera), rng,
                                first_ns + index * period_ns, depth_noise=self.depth_noise or 0)
            if self.depth_noise is None:
                capture.cloud[:] = np.nan
            told = np.eye(4)
            told[:3, 3] = rng.normal(0, self.robot_noise[0], 3)
            told[:3, :3] = Rotation.from_rotvec(
                rng.normal(0, self.robot_noise[1], 3)).as_matrix()
            yield T_base_flange @ told, capture

    def _seen_from(self, rng: np.random.Generator) -> Array:
        """T_camera_board: in view, half a metre away, turned by chance."""
        x, y = rng.uniform(-self.tilt, self.tilt, 2)
        T = _pose((0, 0, 0), (x, y, rng.uniform(-2, 2) * self.tilt))
        middle = self.board.square * np.array((self.board.columns, self.board.rows, 0)) / 2
        place = np.array((rng.uniform(-0.05, 0.05), rng.uniform(-0.03, 0.03),
                          rng.uniform(0.45, 0.65)))
        T[:3, 3] = place - T[:3, :3] @ middle
        return T
