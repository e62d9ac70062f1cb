"""The joints of a simulated LBR Med that hold its flange where a print wants it."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array
from bpc_perception.core.robot.kinematics import flange_pose

# In front of the robot, tool down.
READY = np.radians((0.0, 30.0, 0.0, -60.0, 0.0, 90.0, 0.0))
STEP = 1e-6  # of the numerical derivative [rad]
ITERATIONS = 100
LONGEST_TURN = 0.2  # of a joint in one iteration [rad]
TOLERANCE = 1e-9  # [m] and [rad]


class Arm:
    """Follows poses from one to the next, each from the angles before."""

    def __init__(self, robot: str = 'lbr_med_7') -> None:
        self._robot = robot
        self._angles = READY

    def reach(self, T_base_flange: Array) -> Array:
        """Angles (7,) [rad] that put the flange there. Raises ValueError out of reach."""
        angles = self._angles
        for _ in range(ITERATIONS):
            error = self._error(angles, T_base_flange)
            if np.abs(error).max() < TOLERANCE:
                self._angles = angles
                return angles
            # Seven joints, six equations: the smallest step of all that do.
            jacobian = np.stack([(self._error(angles + STEP * axis, T_base_flange) - error) / STEP
                                 for axis in np.eye(7)], axis=1)
            step = -np.linalg.pinv(jacobian) @ error
            angles = angles + step * min(1.0, LONGEST_TURN / np.abs(step).max())
        raise ValueError(f'arm: expected a pose within reach, found {T_base_flange[:3, 3]}')

    def _error(self, angles: Array, T_base_flange: Array) -> Array:
        """How far (6,) the flange is from where it is wanted [m], [rad]."""
        found = flange_pose(self._robot, angles)
        turned = Rotation.from_matrix(found[:3, :3] @ T_base_flange[:3, :3].T).as_rotvec()
        return np.concatenate((found[:3, 3] - T_base_flange[:3, 3], turned))
