"""Forward kinematics of the KUKA LBR Med: from joint angles to the pose of the flange."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bpc_perception.core.arrays import Array

JOINTS = tuple(f'A{number}' for number in range(1, 8))
# Denavit-Hartenberg d of the joints; a is 0 everywhere. For the Med 7 R800 they are sums of the
# joint origins in its URDF in lbr_fri_ros2_stack. For the first joint of the Med 14 R820 that URDF
# has 0.3595, but the maker's drawing 0.360; the whole cell shifts with it by 0.5 mm.
LINK_OFFSETS_M = {
    'lbr_med_7': (0.340, 0.0, 0.400, 0.0, 0.400, 0.0, 0.126),
    'lbr_med_14': (0.360, 0.0, 0.420, 0.0, 0.400, 0.0, 0.126),
}
LINK_TWISTS_RAD = np.radians((-90.0, 90.0, 90.0, -90.0, -90.0, 90.0, 0.0))  # alpha


def flange_pose(robot: str, angles: Array) -> Array:
    """Return T_base_flange (4, 4) [m] for joint angles (7,) A1..A7 [rad].

    The base is ``lbr_link_0``, the flange ``lbr_link_ee``.

    Raises ValueError if the robot is not known, or the angles are not seven finite numbers.
    """
    return link_poses(robot, angles)[-1]


def link_poses(robot: str, angles: Array) -> list[Array]:
    """Return T_base_link (4, 4) [m] of the base, and of each link behind joints A1..A7.

    The z axis of a link is the axis of the next joint. Arguments and errors: see flange_pose.
    """
    if robot not in LINK_OFFSETS_M:
        raise ValueError(f'robot: expected {" or ".join(LINK_OFFSETS_M)}, found {robot!r}'
                         '; set pose.robot')
    if angles.shape != (len(JOINTS),) or not np.isfinite(angles).all():
        raise ValueError(f'joints: expected {len(JOINTS)} finite angles, found {angles.tolist()}'
                         "; look at the robot's driver")
    poses = [np.eye(4)]
    for c, s, d, ca, sa in zip(np.cos(angles), np.sin(angles), LINK_OFFSETS_M[robot],
                               np.cos(LINK_TWISTS_RAD), np.sin(LINK_TWISTS_RAD), strict=True):
        poses.append(poses[-1] @ np.array((
            (c, -s * ca, s * sa, 0.0), (s, c * ca, -c * sa, 0.0),
            (0.0, sa, ca, d), (0.0, 0.0, 0.0, 1.0))))
    return poses


def may_be_arm(names: Sequence[str]) -> bool:
    """Return whether joints of these names may be the arm's, under whatever names.

    Other devices, such as a plunger, publish their few joints beside it.
    """
    return len(names) >= len(JOINTS) or any(f'_{name}'.endswith(f'_{joint}')
                                            for name in names for joint in JOINTS)


def order_joints(names: Sequence[str], angles: Sequence[float]) -> Array:
    """Return the angles (7,) of A1..A7 [rad] from joints in any order.

    Other joints may be among them. The names may have a prefix that ends with _.

    Raises ValueError unless there is an angle for each name, and each joint is there once.
    """
    if len(names) != len(angles):
        raise ValueError(f'joints: expected an angle for each of {len(names)} names, '
                         f'found {len(angles)}'
                         "; look at the robot's driver")
    # As if each name had a prefix.
    prefixed = [f'_{name}' for name in names]
    found = [[angle for name, angle in zip(prefixed, angles, strict=True)
              if name.endswith(f'_{joint}')] for joint in JOINTS]
    if any(len(values) != 1 for values in found):
        raise ValueError(f'joints: expected each of {", ".join(JOINTS)} once, as such or behind '
                         f'a prefix with _, found {", ".join(names) or "none"}'
                         '; choose the topic of this robot with --remap')
    return np.array(found, np.float64).ravel()
