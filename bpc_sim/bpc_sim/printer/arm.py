"""The joint angles with which an LBR Med holds its flange where a print wants it."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array
from bpc_perception.core.robot.kinematics import flange_pose

READY_POSE_RAD = np.radians((0.0, 30.0, 0.0, -60.0, 0.0, 90.0, 0.0))  # in front, tool down
DERIVATIVE_STEP_RAD = 1e-6
MAX_ITERATIONS = 100
LONGEST_TURN_RAD = 0.2  # of a joint in one iteration
POSE_TOLERANCE = 1e-9  # [m] and [rad]


class Arm:
    """Inverse kinematics by Newton iteration, each time from the angles of the pose before."""

    def __init__(self, robot: str = 'lbr_med_7') -> None:
        self._robot = robot
        self._angles = READY_POSE_RAD

    def joint_angles(self, T_base_flange: Array) -> Array:
        """Return the angles (7,) [rad] that bring the flange to a pose (4, 4).

        Raises:
            ValueError: the pose is out of reach.
        """
        angles = self._angles
        for _ in range(MAX_ITERATIONS):
            error = self._error(angles, T_base_flange)
            if np.abs(error).max() < POSE_TOLERANCE:
                self._angles = angles
                return angles
            # Seven joints, six equations: the smallest of all steps that solve them.
            jacobian = self._jacobian(angles, T_base_flange, error)
            step = -np.linalg.pinv(jacobian) @ error
            angles = angles + step * min(1.0, LONGEST_TURN_RAD / np.abs(step).max())
        raise ValueError(f'arm: expected a pose within reach, found {T_base_flange[:3, 3]}')

    def _jacobian(self, angles: Array, T_base_flange: Array, error: Array) -> Array:
        """Return the derivative (6, 7) of the error by the angles."""
        step = DERIVATIVE_STEP_RAD
        return np.stack([(self._error(angles + step * axis, T_base_flange) - error) / step
                         for axis in np.eye(7)], axis=1)

    def _error(self, angles: Array, T_base_flange: Array) -> Array:
        """Return how far (6,) the flange is from the wanted pose [m], [rad]."""
        found = flange_pose(self._robot, angles)
        turned = Rotation.from_matrix(found[:3, :3] @ T_base_flange[:3, :3].T).as_rotvec()
        return np.concatenate((found[:3, 3] - T_base_flange[:3, 3], turned))
