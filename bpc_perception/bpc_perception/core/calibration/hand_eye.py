"""Hand-eye calibration: the pose of the camera, from captures of a board with flange poses.

Either the board or the camera moves with the flange. With G the pose of what carries the camera
(``eye_in_hand``: T_base_flange; ``eye_on_base``: its inverse, the base as seen from the flange),
X = T_parent_camera and Y the pose of the board in the other frame, every capture says
G X T_camera_board = Y.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.calibration.sighting import Sighting
from bpc_perception.core.geometry import invert
from bpc_perception.core.robot.hand_eye import mount_name

METHODS = {'Tsai-Lenz': cv2.CALIB_HAND_EYE_TSAI, 'Park': cv2.CALIB_HAND_EYE_PARK,
           'Horaud': cv2.CALIB_HAND_EYE_HORAUD, 'Andreff': cv2.CALIB_HAND_EYE_ANDREFF,
           'Daniilidis': cv2.CALIB_HAND_EYE_DANIILIDIS}
FEWEST_CAPTURES = 4
FEW_CAPTURES = 8  # with fewer the result is doubtful
# Rotation of the flange about its second axis below which a solution means nothing, and below
# which it is poor: the error of the result grows with its inverse.
USELESS_TURN_RAD = np.radians(2.0)
POOR_TURN_RAD = np.radians(10.0)
LARGEST_DISAGREEMENT_M = 2e-3  # between methods, above which the result is doubtful
MOUNT_FACTOR = 3  # of residuals, above which the other mount is the right one
ROTATION_TOLERANCE = 1e-6  # of R R^T from the identity


@dataclass(frozen=True)
class Solution:
    """What one method finds.

    Attributes:
        method: its name.
        T_parent_camera: (4, 4) pose of the camera's optical frame [m].
        distances: (N,) between the board as each capture has it and their mean [m].
        angles: (N,) between them [rad].
    """

    method: str
    T_parent_camera: Array
    distances: Array
    angles: Array

    @property
    def rms(self) -> tuple[float, float]:
        """Root mean squares of distances [m] and angles [rad]."""
        return (float(np.sqrt(np.mean(self.distances**2))),
                float(np.sqrt(np.mean(self.angles**2))))


@dataclass(frozen=True)
class HandEyeCalibration:
    """All solutions, the best first, and what is wrong with the captures.

    Attributes:
        solutions: ordered by their residuals.
        sigma: standard deviations of the best one's position [m] and orientation [rad].
        turn: rotation of the flange about its second axis, root mean square [rad].
        warnings: what makes the result doubtful.
    """

    solutions: list[Solution]
    sigma: tuple[float, float]
    turn: float
    warnings: list[str]

    @property
    def best(self) -> Solution:
        """The solution to use."""
        return self.solutions[0]


@dataclass(frozen=True)
class _PosePairs:
    """The poses G and T_camera_board (4, 4) of each capture [m]."""

    G: Sequence[Array]
    T_camera_board: Sequence[Array]

    def __len__(self) -> int:
        return len(self.G)

    def without(self, left_out: int) -> _PosePairs:
        """Return all pairs but one."""
        kept = [index for index in range(len(self)) if index != left_out]
        return _PosePairs([self.G[index] for index in kept],
                          [self.T_camera_board[index] for index in kept])

    def solve(self, method: int) -> Array | None:
        """Return X (4, 4) by a closed-form method of OpenCV; None = it finds none."""
        try:
            R, t = cv2.calibrateHandEye(
                [pose[:3, :3] for pose in self.G], [pose[:3, 3] for pose in self.G],
                [pose[:3, :3] for pose in self.T_camera_board],
                [pose[:3, 3] for pose in self.T_camera_board], method=method)
        except cv2.error:
            return None
        X = np.eye(4)
        X[:3, :3], X[:3, 3] = R, t.ravel()
        orthogonal = np.allclose(X[:3, :3] @ X[:3, :3].T, np.eye(3), atol=ROTATION_TOLERANCE)
        # From poses that do not fit together some methods make a mirrored camera.
        rotates = orthogonal and np.linalg.det(X[:3, :3]) > 0
        return X if np.isfinite(X).all() and rotates else None

    def residuals(self, X: Array) -> tuple[Array, Array]:
        """Return how far each Y is from their mean, with X (4, 4): (N,) [m], (N,) [rad]."""
        boards = np.stack([pose @ X @ board
                           for pose, board in zip(self.G, self.T_camera_board, strict=True)])
        Y = mean_pose(boards)
        turned = Rotation.from_matrix(Y[:3, :3]).inv() * Rotation.from_matrix(boards[:, :3, :3])
        return np.linalg.norm(boards[:, :3, 3] - Y[:3, 3], axis=1), turned.magnitude()


def calibrate(T_base_flange: Sequence[Array], sightings: Sequence[Sighting], on_base: bool,
              use_cloud: bool) -> HandEyeCalibration:
    """Find T_parent_camera from flange poses and what the camera saw at each.

    Args:
        T_base_flange: N poses (4, 4) [m].
        sightings: of the board, N.
        on_base: whether the camera stands beside the robot, and the flange carries the board.
        use_cloud: take the positions of corners in space from the cloud, not from perspective.

    Raises:
        CalibrationError: too few captures, poses too alike to tell anything, or a camera that is
            mounted the other way.
    """
    if len(sightings) < FEWEST_CAPTURES:
        raise CalibrationError(f'hand-eye: expected {FEWEST_CAPTURES} captures of the board or '
                               f'more, found {len(sightings)}'
                               '; record more, with all of it in the picture')
    boards = [board_pose(sighting, use_cloud) for sighting in sightings]
    inverse = [invert(pose) for pose in T_base_flange]
    pairs = _PosePairs(inverse if on_base else T_base_flange, boards)
    others = _PosePairs(T_base_flange if on_base else inverse, boards)
    turn = second_turn(pairs.G)
    if turn < USELESS_TURN_RAD:
        raise CalibrationError(
            'hand-eye: expected poses turned about two axes, by 30 degrees or so, found them '
            f'turned by {np.degrees(turn):.2g} degrees about the second'
            '; turn the flange about others, too')
    solutions = _solutions(pairs)
    _expect_mount(on_base, solutions, _solutions(others))
    if not solutions:
        raise CalibrationError('hand-eye: expected a solution, found none with any method; record '
                               'captures with the board seen from more sides')
    return HandEyeCalibration(solutions, _sigma(pairs, solutions[0]), turn,
                              _warnings(solutions, len(pairs), turn))


def board_pose(sighting: Sighting, use_cloud: bool) -> Array:
    """Return T_camera_board (4, 4) [m], from corners in space or, by perspective, in the image.

    Raises CalibrationError if perspective gives none.
    """
    if use_cloud:
        return fit_rigid(sighting.on_board, sighting.in_camera)
    found, rotation, translation = cv2.solvePnP(
        sighting.on_board, sighting.uv, sighting.camera.K, sighting.camera.distortion)
    if not found:
        raise CalibrationError('board: expected a pose of the corners, found none'
                               '; show more of the board')
    T_camera_board = np.eye(4)
    T_camera_board[:3, :3] = cv2.Rodrigues(rotation)[0]
    T_camera_board[:3, 3] = translation.ravel()
    return T_camera_board


def fit_rigid(source: Array, target: Array) -> Array:
    """Return T_target_source (4, 4) that takes points (N, 3) onto others with least squares.

    [Kabsch 1976; the sign by Umeyama 1991]
    """
    middle_source, middle_target = source.mean(axis=0), target.mean(axis=0)
    U, _, Vt = np.linalg.svd((target - middle_target).T @ (source - middle_source))
    sign = np.diag((1.0, 1.0, np.sign(np.linalg.det(U @ Vt))))
    T_target_source = np.eye(4)
    T_target_source[:3, :3] = U @ sign @ Vt
    T_target_source[:3, 3] = middle_target - T_target_source[:3, :3] @ middle_source
    return T_target_source


def second_turn(poses: Sequence[Array]) -> float:
    """Return by how much poses (4, 4) turn about their second axis, root mean square [rad].

    Axes are ordered by how much the poses turn about them. Rotations about one axis only leave the
    camera's position along that axis open [Tsai and Lenz 1989, lemma on non-parallel axes].
    """
    rotations = Rotation.from_matrix([pose[:3, :3] for pose in poses])
    vectors = (rotations.mean().inv() * rotations).as_rotvec()
    spread: Array = np.linalg.svd(vectors, compute_uv=False) / np.sqrt(len(poses))
    return float(spread[1])


def mean_pose(poses: Array) -> Array:
    """Return the mean (4, 4) of poses (N, 4, 4)."""
    mean = np.eye(4)
    mean[:3, :3] = Rotation.from_matrix(poses[:, :3, :3]).mean().as_matrix()
    mean[:3, 3] = poses[:, :3, 3].mean(axis=0)
    return mean


def _solutions(pairs: _PosePairs) -> list[Solution]:
    """Return what each method finds, the smallest residuals first."""
    found = []
    for name, method in METHODS.items():
        X = pairs.solve(method)
        if X is not None:
            found.append(Solution(name, X, *pairs.residuals(X)))
    return sorted(found, key=lambda each: each.rms[0])


def _expect_mount(on_base: bool, asked: Sequence[Solution], other: Sequence[Solution]) -> None:
    """Raise CalibrationError if captures fit a camera that is mounted the other way much better.

    Args:
        on_base: how it is said to be mounted.
        asked: solutions for this mount, the best first.
        other: those for the other mount.
    """
    residual, other_residual = (each[0].rms[0] if each else np.inf for each in (asked, other))
    if residual <= MOUNT_FACTOR * other_residual:
        return
    mount, other_mount = mount_name(on_base), mount_name(not on_base)
    instead = f'{residual * 1e3:.2f} mm' if asked else 'no solution'
    raise CalibrationError(
        f'hand-eye: expected captures that fit {mount}, found that they fit {other_mount}, with a '
        f'residual of {other_residual * 1e3:.2f} mm instead of {instead}; give '
        f'--mount {other_mount}')


def _sigma(pairs: _PosePairs, best: Solution) -> tuple[float, float]:
    """Return standard deviations of position [m] and orientation [rad], by leaving one out.

    NaN if there is no solution without one of the captures. [Efron and Stein 1981]
    """
    X = best.T_parent_camera
    moved, turned = [], []
    for left_out in range(len(pairs)):
        other = pairs.without(left_out).solve(METHODS[best.method])
        if other is None:
            return float('nan'), float('nan')
        moved.append(np.sum((other[:3, 3] - X[:3, 3])**2))
        turned.append(Rotation.from_matrix(other[:3, :3] @ X[:3, :3].T).magnitude()**2)
    share = (len(pairs) - 1) / len(pairs)
    return float(np.sqrt(share * np.sum(moved))), float(np.sqrt(share * np.sum(turned)))


def _warnings(solutions: Sequence[Solution], count: int, turn: float) -> list[str]:
    found = []
    if turn < POOR_TURN_RAD:
        found.append(f'the poses are too alike: about a second axis they are turned by '
                     f'{np.degrees(turn):.1f} degrees only, expected '
                     f'{np.degrees(POOR_TURN_RAD):.0f} or more')
    if count < FEW_CAPTURES:
        found.append(f'{count} captures are few: expected {FEW_CAPTURES} or more')
    apart = max(float(np.linalg.norm(each.T_parent_camera[:3, 3]
                                     - solutions[0].T_parent_camera[:3, 3]))
                for each in solutions)
    if apart > LARGEST_DISAGREEMENT_M:
        found.append(f'the methods disagree by up to {apart * 1e3:.1f} mm: a capture or pose is '
                     'wrong, or the poses are too alike')
    return found
