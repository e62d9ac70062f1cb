"""Hand-eye calibration on synthetic boards, where the camera's pose is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.board import Board
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.calibration.hand_eye import calibrate, HandEyeCalibration, METHODS
from bpc_perception.core.calibration.sighting import find_board
from bpc_perception.core.geometry import invert, transform
from bpc_sim.scene.calibration_rig import CalibrationRig

CHECKERBOARD = Board(9, 6, 0.02)
CHARUCO = Board(9, 6, 0.02, 0.015)
MAX_TRANSLATION_M, MAX_ROTATION_RAD = 2e-4, np.radians(0.05)  # errors


def errors(found: Array, true: Array) -> tuple[float, float]:
    """Return distance [m] and angle [rad] between two poses (4, 4)."""
    turned = Rotation.from_matrix(found[:3, :3].T @ true[:3, :3]).magnitude()
    return float(np.linalg.norm(found[:3, 3] - true[:3, 3])), float(turned)


def calibrated(rig: CalibrationRig, count: int = 12, use_cloud: bool = True) -> HandEyeCalibration:
    """Calibrate with captures of a rig."""
    poses, sightings = [], []
    for T_base_flange, capture in rig.captures(count):
        poses.append(T_base_flange)
        sightings.append(find_board(capture, rig.board))
    return calibrate(poses, sightings, rig.on_base, use_cloud)


@pytest.mark.accuracy
@pytest.mark.parametrize('on_base', [True, False], ids=['eye_on_base', 'eye_in_hand'])
@pytest.mark.parametrize('board', [CHECKERBOARD, CHARUCO], ids=['checkerboard', 'charuco'])
def test_the_camera_is_found(board: Board, on_base: bool) -> None:
    rig = CalibrationRig(board, on_base)
    found = calibrated(rig)
    distance, angle = errors(found.best.T_parent_camera, rig.T_parent_camera)
    assert distance < MAX_TRANSLATION_M
    assert angle < MAX_ROTATION_RAD
    # The stated uncertainty is about right, and all methods agree.
    assert distance < 3 * found.sigma[0]
    assert angle < 3 * found.sigma[1]
    assert {each.method for each in found.solutions} == set(METHODS)
    for each in found.solutions:
        assert errors(each.T_parent_camera, rig.T_parent_camera)[0] < 2 * MAX_TRANSLATION_M
    residuals = [each.rms[0] for each in found.solutions]
    assert residuals == sorted(residuals)
    assert residuals[0] < 2e-4
    assert found.warnings == []


@pytest.mark.parametrize('board', [CHECKERBOARD, CHARUCO], ids=['checkerboard', 'charuco'])
def test_corners_are_found_where_they_are(board: Board) -> None:
    rig = CalibrationRig(board, on_base=True, tilt=40)
    for T_base_flange, capture in CalibrationRig(
            board, on_base=True, tilt=40, robot_noise=(0, 0)).captures(4):
        T_camera_board = invert(rig.T_base_camera) @ T_base_flange @ rig.T_flange_board
        sighting = find_board(capture, board)
        true = transform(T_camera_board, sighting.on_board)
        assert len(true) == 40
        assert np.abs(sighting.uv - capture.camera.pixels(true)).max() < 0.2
        np.testing.assert_allclose(sighting.in_camera, true, atol=2e-4)
        assert sighting.scale == pytest.approx(1, abs=1e-3)


@pytest.mark.accuracy
def test_without_a_cloud_perspective_does_but_worse() -> None:
    rig = CalibrationRig(CHARUCO, on_base=False, depth_noise=None)
    found = calibrated(rig, use_cloud=False)
    distance, angle = errors(found.best.T_parent_camera, rig.T_parent_camera)
    assert 0 < distance < 1e-3
    assert angle < 2 * MAX_ROTATION_RAD
    _, capture = next(rig.captures(1))
    sighting = find_board(capture, CHARUCO)
    assert not sighting.has_depth
    assert np.isnan(sighting.in_camera).all()


def test_poses_too_alike_are_warned_about_and_then_refused() -> None:
    found = calibrated(CalibrationRig(CHARUCO, on_base=True, tilt=6), 6)
    assert any('too alike' in warning for warning in found.warnings)
    with pytest.raises(CalibrationError, match='expected poses turned about two axes'):
        calibrated(CalibrationRig(CHARUCO, on_base=True, tilt=1), 4)


def test_few_captures_are_warned_about_and_then_refused() -> None:
    found = calibrated(CalibrationRig(CHARUCO, on_base=True), 5)
    assert any('5 captures are few' in warning for warning in found.warnings)
    with pytest.raises(CalibrationError, match=r'expected 4 captures .*, found 3'):
        calibrated(CalibrationRig(CHARUCO, on_base=True), 3)


@pytest.mark.parametrize(('printed', 'given', 'words'), [
    (CHARUCO, Board(9, 6, 0.021, 0.0157), 'expected squares of 21 mm, found 20'),
    (CHECKERBOARD, Board(9, 6, 0.0195), 'expected squares of 19.5 mm, found 20'),
    (CHECKERBOARD, CHARUCO, 'expected 8 corners or more, found 0'),
    (CHECKERBOARD, Board(8, 7, 0.02), 'expected 8 corners or more, found 0'),
])
def test_another_board_is_refused(printed: Board, given: Board, words: str) -> None:
    _, capture = next(CalibrationRig(printed, on_base=True).captures(1))
    with pytest.raises(CalibrationError, match=words):
        find_board(capture, given)


@pytest.mark.parametrize(('arguments', 'words'), [
    ((9, 7, 0.02), 'an even and an odd number'),
    ((9, 3, 0.02), 'expected 4 x 4 squares or more'),
    ((9, 6, 0.0), 'expected 4 x 4 squares or more'),
    ((9, 6, 0.02, 0.02), 'expected markers smaller'),
    ((9, 6, 0.02, 0.015, 'DICT_9'), 'expected a dictionary of OpenCV'),
])
def test_boards_that_tell_nothing_are_refused(arguments: tuple[float, ...], words: str) -> None:
    with pytest.raises(CalibrationError, match=words):
        Board(*arguments)  # type: ignore[arg-type]
