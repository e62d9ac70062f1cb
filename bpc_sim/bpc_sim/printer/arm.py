"""The joint angles with which an LBR Med holds its flange where a print wants it."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array
from bpc_perception.core.robot.kinematics import link_poses

READY_POSE_RAD = np.radians((0.0, 30.0, 0.0, -60.0, 0.0, 90.0, 0.0))  # in front, tool down
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
            links = link_poses(self._robot, angles)
            error = _error(links[-1], T_base_flange)
            if np.abs(error).max() < POSE_TOLERANCE:
                self._angles = angles
                return angles
            # Seven joints, six equations: the smallest of all steps that solve them.
            step = -np.linalg.pinv(_jacobian(links)) @ error
            angles = angles + step * min(1.0, LONGEST_TURN_RAD / np.abs(step).max())
        raise ValueError(f'arm: expected a pose within reach, found {T_base_flange[:3, 3]}')


def _jacobian(links: list[Array]) -> Array:
    """Return how (6, 7) the flange moves [m] and turns [rad] by each joint [Whitney 1972]."""
    poses = np.stack(links)
    axes, arms = poses[:-1, :3, 2], poses[-1, :3, 3] - poses[:-1, :3, 3]
    return np.concatenate((np.cross(axes, arms), axes), axis=1).T


def _error(found: Array, wanted: Array) -> Array:
    """Return how far (6,) a pose (4, 4) is from the wanted one [m], [rad]."""
    turned = Rotation.from_matrix(found[:3, :3] @ wanted[:3, :3].T).as_rotvec()
    return np.concatenate((found[:3, 3] - wanted[:3, 3], turned))
