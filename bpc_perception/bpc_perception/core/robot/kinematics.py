"""Forward kinematics of the KUKA LBR Med: where the flange is, from the joints' angles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bpc_perception.core.arrays import Array

JOINTS = tuple(f'A{number}' for number in range(1, 8))
# Denavit-Hartenberg d of the joints [m]; a is 0 everywhere. Those of the Med 7 R800 add up the
# joint origins of its URDF in lbr_fri_ros2_stack. That URDF has 0.3595 for the first of the
# Med 14 R820, for which the maker's drawing has 0.360; the whole cell shifts with it by 0.5 mm.
LINKS = {
    'lbr_med_7': (0.340, 0.0, 0.400, 0.0, 0.400, 0.0, 0.126),
    'lbr_med_14': (0.360, 0.0, 0.420, 0.0, 0.400, 0.0, 0.126),
}
TWISTS = np.radians((-90.0, 90.0, 90.0, -90.0, -90.0, 90.0, 0.0))  # alpha


def flange_pose(robot: str, angles: Array) -> Array:
    """T_base_flange (4, 4), ``lbr_link_0`` to ``lbr_link_ee``, for angles (7,) A1..A7 [rad].

    Raises ValueError for a robot not known, or angles that are not seven finite numbers.
    """
    if robot not in LINKS:
        raise ValueError(f'robot: expected {" or ".join(LINKS)}, found {robot!r}')
    if angles.shape != (len(JOINTS),) or not np.isfinite(angles).all():
        raise ValueError(f'joints: expected {len(JOINTS)} finite angles, found {angles.tolist()}')
    T_base_link = np.eye(4)
    for theta, d, alpha in zip(angles, LINKS[robot], TWISTS, strict=True):
        c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        T_base_link = T_base_link @ np.array((
            (c, -s * ca, s * sa, 0.0), (s, c * ca, -c * sa, 0.0),
            (0.0, sa, ca, d), (0.0, 0.0, 0.0, 1.0)))
    return T_base_link


def order_joints(names: Sequence[str], angles: Sequence[float]) -> Array:
    """Angles (7,) A1..A7 of joints that may come in any order, among others, and with a prefix.

    Raises ValueError unless each joint is there once.
    """
    if len(names) != len(angles):
        raise ValueError(f'joints: expected an angle for each of {len(names)} names, '
                         f'found {len(angles)}')
    found = [[angle for name, angle in zip(names, angles, strict=True)
              if name == joint or name.endswith(f'_{joint}')] for joint in JOINTS]
    if any(len(values) != 1 for values in found):
        raise ValueError(f'joints: expected each of {", ".join(JOINTS)} once, as such or behind '
                         f'a prefix with _, found {", ".join(names) or "none"}')
    return np.array(found, np.float64).ravel()
