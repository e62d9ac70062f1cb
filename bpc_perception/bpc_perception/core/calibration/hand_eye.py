"""Hand-eye calibration: where the camera is, from captures of a board with flange poses.

One of board and camera moves with the flange. With G the pose of that which carries the camera
(``eye_in_hand``: T_base_flange, ``eye_on_base``: its inverse, the base seen from the flange),
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
from bpc_perception.core.calibration.board import Sighting
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.geometry import invert

METHODS = {'Tsai-Lenz': cv2.CALIB_HAND_EYE_TSAI, 'Park': cv2.CALIB_HAND_EYE_PARK,
           'Horaud': cv2.CALIB_HAND_EYE_HORAUD, 'Andreff': cv2.CALIB_HAND_EYE_ANDREFF,
           'Daniilidis': cv2.CALIB_HAND_EYE_DANIILIDIS}
FEWEST_CAPTURES = 4
# Rotation of the flange about its second axis below which a solution means nothing, and below
# which it is poor: the error of the result grows with its inverse [rad].
USELESS_TURN, POOR_TURN = np.radians(2.0), np.radians(10.0)
FEW_CAPTURES = 8


@dataclass(frozen=True)
class Solution:
    """What a method finds.

    Attributes:
        method: its name.
        T_parent_camera: (4, 4) pose of the camera's optical frame.
        distances: (N,) how far each capture puts the board from where all together put it [m].
        angles: (N,) how far it turns it from there [rad].
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
        sigma: standard deviations of the best's position [m] and orientation [rad].
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


def board_pose(sighting: Sighting, use_cloud: bool) -> Array:
    """T_camera_board (4, 4), from corners in space or, by perspective, in the image alone."""
    if use_cloud:
        return fit_rigid(sighting.on_board, sighting.in_camera)
    found, rotation, translation = cv2.solvePnP(
        sighting.on_board, sighting.uv, sighting.camera.K, sighting.camera.distortion)
    if not found:
        raise CalibrationError('board: expected a pose of the corners, found none')
    T_camera_board = np.eye(4)
    T_camera_board[:3, :3] = cv2.Rodrigues(rotation)[0]
    T_camera_board[:3, 3] = translation.ravel()
    return T_camera_board


def fit_rigid(source: Array, target: Array) -> Array:
    """T_target_source (4, 4) that takes points (N, 3) onto others with the least squares.

    [Kabsch 1976; the sign by Umeyama 1991]
    """
    middle_source, middle_target = source.mean(axis=0), target.mean(axis=0)
    U, _, Vt = np.linalg.svd((target - middle_target).T @ (source - middle_source))
    sign = np.diag((1.0, 1.0, np.sign(np.linalg.det(U @ Vt))))
    T_target_source = np.eye(4)
    T_target_source[:3, :3] = U @ sign @ Vt
    T_target_source[:3, 3] = middle_target - T_target_source[:3, :3] @ middle_source
    return T_target_source


def calibrate(T_base_flange: Sequence[Array], sightings: Sequence[Sighting], on_base: bool,
              use_cloud: bool) -> HandEyeCalibration:
    """Find T_parent_camera from flange poses and what the camera saw at each.

    ``use_cloud`` takes the corners' positions in space from the cloud, else from perspective.
    Raises CalibrationError with too few captures, or poses too alike to tell anything.
    """
    count = len(sightings)
    if count < FEWEST_CAPTURES:
        raise CalibrationError(f'hand-eye: expected {FEWEST_CAPTURES} captures of the board or '
                               f'more, found {count}')
    G = [invert(pose) if on_base else pose for pose in T_base_flange]
    T_camera_board = [board_pose(sighting, use_cloud) for sighting in sightings]
    turn = second_turn(G)
    if turn < USELESS_TURN:
        raise CalibrationError(
            'hand-eye: expected poses turned about two axes, by 30 degrees or so, found them '
            f'turned by {np.degrees(turn):.2g} degrees about the second')
    solutions = [Solution(name, X, *_residuals(G, X, T_camera_board))
                 for name, method in METHODS.items()
                 if (X := _closed_form(method, G, T_camera_board)) is not None]
    if not solutions:
        raise CalibrationError('hand-eye: expected a solution, found none with any method')
    solutions.sort(key=lambda each: each.rms[0])
    best = solutions[0]
    sigma = _sigma(METHODS[best.method], G, best.T_parent_camera, T_camera_board)
    return HandEyeCalibration(solutions, sigma, turn, _warnings(solutions, count, turn))


def second_turn(G: Sequence[Array]) -> float:
    """How far poses are turned about the second most used axis, root mean square [rad].

    Rotations about one axis only leave the camera's position along that axis open [Tsai and
    Lenz 1989, lemma on non-parallel axes].
    """
    middle = Rotation.from_matrix([pose[:3, :3] for pose in G]).mean()
    vectors = (middle.inv() * Rotation.from_matrix([pose[:3, :3] for pose in G])).as_rotvec()
    spread: Array = np.linalg.svd(vectors, compute_uv=False) / np.sqrt(len(G))
    return float(spread[1])


def _closed_form(method: int, G: Sequence[Array], T_camera_board: Sequence[Array]) -> Array | None:
    try:
        R, t = cv2.calibrateHandEye(
            [pose[:3, :3] for pose in G], [pose[:3, 3] for pose in G],
            [pose[:3, :3] for pose in T_camera_board], [pose[:3, 3] for pose in T_camera_board],
            method=method)
    except cv2.error:
        return None
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = R, t.ravel()
    orthogonal = np.allclose(X[:3, :3] @ X[:3, :3].T, np.eye(3), atol=1e-6)
    return X if np.isfinite(X).all() and orthogonal else None


def _boards(G: Sequence[Array], X: Array, T_camera_board: Sequence[Array]) -> Array:
    return np.stack([pose @ X @ board for pose, board in zip(G, T_camera_board, strict=True)])


def mean_pose(poses: Array) -> Array:
    """The mean (4, 4) of poses (N, 4, 4)."""
    mean = np.eye(4)
    mean[:3, :3] = Rotation.from_matrix(poses[:, :3, :3]).mean().as_matrix()
    mean[:3, 3] = poses[:, :3, 3].mean(axis=0)
    return mean


def _residuals(G: Sequence[Array], X: Array,
               T_camera_board: Sequence[Array]) -> tuple[Array, Array]:
    boards = _boards(G, X, T_camera_board)
    Y = mean_pose(boards)
    turned = Rotation.from_matrix(Y[:3, :3]).inv() * Rotation.from_matrix(boards[:, :3, :3])
    return np.linalg.norm(boards[:, :3, 3] - Y[:3, 3], axis=1), turned.magnitude()


def _sigma(method: int, G: Sequence[Array], X: Array,
           T_camera_board: Sequence[Array]) -> tuple[float, float]:
    """Standard deviations of X's position [m] and orientation [rad], by leaving one out.

    [Efron and Stein 1981]
    """
    count = len(G)
    moved, turned = [], []
    for left_out in range(count):
        keep = [index for index in range(count) if index != left_out]
        other = _closed_form(method, [G[index] for index in keep],
                             [T_camera_board[index] for index in keep])
        if other is None:
            return float('nan'), float('nan')
        moved.append(np.sum((other[:3, 3] - X[:3, 3])**2))
        turned.append(Rotation.from_matrix(other[:3, :3] @ X[:3, :3].T).magnitude()**2)
    share = (count - 1) / count
    return float(np.sqrt(share * np.sum(moved))), float(np.sqrt(share * np.sum(turned)))


def _warnings(solutions: Sequence[Solution], count: int, turn: float) -> list[str]:
    found = []
    if turn < POOR_TURN:
        found.append(f'the poses are too alike: about a second axis they are turned by '
                     f'{np.degrees(turn):.1f} degrees only, expected '
                     f'{np.degrees(POOR_TURN):.0f} or more')
    if count < FEW_CAPTURES:
        found.append(f'{count} captures are few: expected {FEW_CAPTURES} or more')
    apart = max(float(np.linalg.norm(each.T_parent_camera[:3, 3]
                                     - solutions[0].T_parent_camera[:3, 3]))
                for each in solutions)
    if apart > 2e-3:
        found.append(f'the methods disagree by up to {apart * 1e3:.1f} mm: a capture or pose is '
                     'wrong, or the poses are too alike')
    return found
