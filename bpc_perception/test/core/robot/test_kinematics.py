"""The flange of the LBR Med, against poses worked out from its URDF and from its drawing."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bpc_perception.core.robot.kinematics import (
    flange_pose,
    JOINTS,
    may_be_arm,
    order_joints,
)

# Joint angles [degrees], then position [m] and quaternion x, y, z, w of lbr_link_ee in lbr_link_0:
# the joint origins and axes of the URDF multiplied out, independently of any parameters here.
MED_7 = [
    ((0, 0, 0, 0, 0, 0, 0), (0, 0, 1.266), (0, 0, 0, 1)),
    ((0, 90, 0, 0, 0, 0, 0), (0.926, 0, 0.340), (0, 0.707107, 0, 0.707107)),
    ((0, 30, 0, -60, 0, 90, 0), (0.600, 0, 0.56041), (0, 1, 0, 0)),
    ((0, 45, 0, -90, 0, 45, 0), (0.565685, 0, 0.214), (0, 1, 0, 0)),
    ((10, 20, 30, -40, 50, 60, 70), (0.438832, 0.329267, 0.917028),
     (-0.229787, -0.699560, -0.665652, 0.121331)),
    ((-30, 25, 15, -75, 10, 80, -45), (0.538943, -0.155888, 0.517601),
     (-0.230495, 0.962880, 0.117799, 0.076539)),
]
# Added up by hand: upright 0.36 + 0.42 + 0.4 + 0.126; bent at A2 the upper three lie along x;
# bent at A4 the upper two do, towards +x, since A4 turns about -y.
MED_14 = [
    ((0, 0, 0, 0, 0, 0, 0), (0, 0, 1.306), (0, 0, 0, 1)),
    ((0, 90, 0, 0, 0, 0, 0), (0.946, 0, 0.360), (0, 0.707107, 0, 0.707107)),
    ((0, 0, 0, -90, 0, 0, 0), (0.526, 0, 0.780), (0, 0.707107, 0, 0.707107)),
    ((90, 0, 0, -90, 0, 90, 0), (0, 0.4, 0.654), (-0.707107, 0.707107, 0, 0)),
]


@pytest.mark.parametrize(('robot', 'angles', 'position', 'quaternion'), [
    *(('lbr_med_7', *row) for row in MED_7), *(('lbr_med_14', *row) for row in MED_14)])
def test_golden_poses(robot: str, angles: tuple[float, ...], position: tuple[float, ...],
                      quaternion: tuple[float, ...]) -> None:
    found = flange_pose(robot, np.radians(angles))
    np.testing.assert_allclose(found[:3, 3], position, atol=1e-6)
    turned = Rotation.from_matrix(found[:3, :3]).inv() * Rotation.from_quat(quaternion)
    assert turned.magnitude() < 3e-6  # the quaternions have six digits


def test_joints_are_told_by_name_in_any_order() -> None:
    names = ['gripper', *(f'lbr_{joint}' for joint in reversed(JOINTS))]
    found = order_joints(names, [99.0, 7, 6, 5, 4, 3, 2, 1])
    assert found.tolist() == [1, 2, 3, 4, 5, 6, 7]
    assert order_joints(JOINTS, found.tolist()).tolist() == found.tolist()


@pytest.mark.parametrize(('names', 'count'), [
    (JOINTS[:6], 6), ((*JOINTS, 'other_A1'), 8), (JOINTS, 6), ((), 0),
    (tuple(f'x{joint}' for joint in JOINTS), 7)])
def test_other_joints_are_refused(names: tuple[str, ...], count: int) -> None:
    with pytest.raises(ValueError, match=r'^joints: expected .*, found '):
        order_joints(names, [0.0] * count)


@pytest.mark.parametrize(('names', 'expected'), [
    (['plunger'], False), (['gripper', 'finger'], False), ([], False), (['lbr_A1'], True),
    (['A7'], True), ([f'joint_a{number}' for number in range(1, 8)], True)])
def test_joints_of_other_devices_are_told_from_an_arm(names: list[str], expected: bool) -> None:
    """Seven joints of other names may be an arm whose names are not known here."""
    assert may_be_arm(names) == expected


def test_a_wrong_robot_or_angles_that_are_none_are_refused() -> None:
    with pytest.raises(ValueError, match='expected lbr_med_7 or lbr_med_14, found'):
        flange_pose('lbr_iiwa', np.zeros(7))
    with pytest.raises(ValueError, match='expected 7 finite angles'):
        flange_pose('lbr_med_7', np.array([0, 0, 0, np.nan, 0, 0, 0]))
