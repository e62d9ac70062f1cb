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
from bpc_sim.scene.board_capture import capture_board
from bpc_sim.scene.camera import M70_HEIGHT_PX, M70_WIDTH_PX, View, zivid_m70


def _pose(xyz: tuple[float, float, float], angles: tuple[float, float, float]) -> Array:
    """Return a pose (4, 4) from a position [m] and angles about x, y and z [degrees]."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler('xyz', angles, degrees=True).as_matrix()
    pose[:3, 3] = xyz
    return pose


@dataclass(frozen=True, eq=False)
class CalibrationRig:
    """A camera beside the robot and a board on its flange, or the other way round.

    Attributes:
        board: the calibration board.
        on_base: whether the camera stands beside the robot.
        scale: scale of the camera's full image; 0.5 = 2 x 2 sub-sampling.
        tilt: largest angle by which the board is turned to a side [degrees].
        robot_noise: standard deviations of the poses that the robot reports [m], [rad].
        depth_noise: as in capture_board; None = a camera without a cloud.
        seed: seed of poses and noise.
        T_base_camera, T_flange_board: (4, 4) poses where the camera stands beside the robot.
        T_flange_camera, T_base_board: (4, 4) poses where the camera is on the flange.
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
        """Pose (4, 4) of the camera in base or flange, which a calibration has to find."""
        return self.T_base_camera if self.on_base else self.T_flange_camera

    def captures(self, count: int, first_ns: int = 0,
                 period_ns: int = 0) -> Iterator[tuple[Array, Capture]]:
        """Yield T_base_flange (4, 4) as the robot reports it, and the capture taken there."""
        rng = np.random.default_rng(self.seed)
        size = round(M70_WIDTH_PX * self.scale), round(M70_HEIGHT_PX * self.scale)
        camera = zivid_m70(*size, self.scale)
        for index in range(count):
            T_camera_board = self._random_board_pose(rng)
            if self.on_base:
                T_base_camera = self.T_base_camera
                T_base_board = T_base_camera @ T_camera_board
                T_base_flange = T_base_board @ invert(self.T_flange_board)
            else:
                T_base_board = self.T_base_board
                T_base_camera = T_base_board @ invert(T_camera_board)
                T_base_flange = T_base_camera @ invert(self.T_flange_camera)
            capture = capture_board(
                self.board, T_base_board, View(camera, T_base_camera), rng,
                first_ns + index * period_ns, depth_noise=self.depth_noise or 0)
            if self.depth_noise is None:
                capture.cloud[:] = np.nan
            error = np.eye(4)
            error[:3, 3] = rng.normal(0, self.robot_noise[0], 3)
            error[:3, :3] = Rotation.from_rotvec(
                rng.normal(0, self.robot_noise[1], 3)).as_matrix()
            yield T_base_flange @ error, capture

    def _random_board_pose(self, rng: np.random.Generator) -> Array:
        """Return T_camera_board (4, 4): in view, about half a metre away, randomly turned."""
        x, y = rng.uniform(-self.tilt, self.tilt, 2)
        T = _pose((0, 0, 0), (x, y, rng.uniform(-2, 2) * self.tilt))
        middle = self.board.square * np.array((self.board.columns, self.board.rows, 0)) / 2
        place = np.array((rng.uniform(-0.05, 0.05), rng.uniform(-0.03, 0.03),
                          rng.uniform(0.45, 0.65)))
        T[:3, 3] = place - T[:3, :3] @ middle
        return T
