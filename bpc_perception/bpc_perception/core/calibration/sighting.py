"""A calibration board in a capture: its corners in the image and in space."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.board import Board
from bpc_perception.core.calibration.corners import find_corners
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.capture.capture import Capture, PinholeCamera

FEWEST_CORNERS = 8
# Share of the pixels among the corners that need a depth; else the cloud says too little.
LEAST_DEPTH_SHARE = 0.3
PLANE_ROUNDS = 3  # of fitting the board's plane without what lies off it
SCALE_TOLERANCE = 0.01  # by which squares in the cloud may differ from the size given
SIGMA_PER_MEDIAN = 1.4826  # standard deviation of a normal distribution, per median of |x|
OFF_PLANE_SIGMAS = 3  # from the board's plane; what is farther is not of the board
LEAST_SIGMA_M = 1e-6


@dataclass(frozen=True)
class Sighting:
    """A board found in a capture.

    Attributes:
        on_board: (N, 3) corners in the board's frame [m].
        uv: (N, 2) the same in the image [pixels].
        in_camera: (N, 3) the same in the camera's optical frame, from the cloud [m]; NaN where
            the cloud says too little.
        scale: size of the squares in the cloud, per size given; NaN if the cloud says too little.
        camera: intrinsics.
    """

    on_board: Array
    uv: Array
    in_camera: Array
    scale: float
    camera: PinholeCamera

    @property
    def has_depth(self) -> bool:
        """Whether the cloud shows the board."""
        return bool(np.isfinite(self.scale))


def find_board(capture: Capture, board: Board) -> Sighting:
    """Find a board in a capture.

    Raises CalibrationError if it is not seen, or has another size.
    """
    ids, uv = find_corners(capture.image, board)
    if len(ids) < FEWEST_CORNERS:
        raise CalibrationError(f'board: expected {FEWEST_CORNERS} corners or more, '
                               f'found {len(ids)}'
                               '; show all of it, sharp and evenly lit, and see that the '
                               'options are those of this board')
    on_board = board.corners[ids]
    in_camera = corners_in_space(capture, uv)
    scale = float('nan')
    if np.isfinite(in_camera).all():
        scale = _size(in_camera) / _size(on_board)
        if abs(scale - 1) > SCALE_TOLERANCE:
            raise CalibrationError(
                f'board: expected squares of {board.square * 1e3:g} mm, found '
                f'{board.square * scale * 1e3:.4g} mm in the cloud'
                '; measure them, or let the camera be calibrated')
    return Sighting(on_board, uv, in_camera, scale, capture.camera)


def corners_in_space(capture: Capture, uv: Array) -> Array:
    """Return corners (N, 3) in the camera's frame [m] from their pixels (N, 2).

    They are where their rays meet the board's plane. The plane is fitted to all points between the
    corners: this averages their noise, and needs no point at a corner itself, since depth is at
    its worst at the border of dark and light. NaN if too few of these points are known.
    """
    points = _points_between(capture, uv)
    finite = np.isfinite(points).all(axis=1)
    if finite.mean() < LEAST_DEPTH_SHARE:
        return np.full((len(uv), 3), np.nan)
    centre, normal = _fit_plane(points[finite])
    rays = _rays(capture.camera, uv)
    return rays * (normal @ centre / (rays @ normal))[:, None]


def _points_between(capture: Capture, uv: Array) -> Array:
    """Return the points (K, 3) of the cloud within the convex hull of pixels (N, 2)."""
    mask = np.zeros(capture.image.shape[:2], np.uint8)
    cv2.fillConvexPoly(mask, cv2.convexHull(np.rint(uv).astype(np.int32)), 1)
    return capture.cloud[mask > 0].astype(np.float64)


def _fit_plane(points: Array) -> tuple[Array, Array]:
    """Return centre (3,) and unit normal (3,) of the plane through most of the points (K, 3)."""
    keep = np.ones(len(points), bool)
    for _ in range(PLANE_ROUNDS):
        centre = points[keep].mean(axis=0)
        _, axes = np.linalg.eigh(np.cov((points[keep] - centre).T))
        normal = axes[:, 0]  # of the smallest eigenvalue
        height = (points - centre) @ normal
        sigma = max(SIGMA_PER_MEDIAN * float(np.median(np.abs(height))), LEAST_SIGMA_M)
        keep = np.abs(height) <= OFF_PLANE_SIGMAS * sigma
    return centre, normal


def _rays(camera: PinholeCamera, uv: Array) -> Array:
    """Return viewing rays (N, 3) of pixels (N, 2) in the camera's frame, with z = 1."""
    xy = cv2.undistortPoints(uv.reshape(-1, 1, 2), camera.K, camera.distortion).reshape(-1, 2)
    return np.column_stack((xy, np.ones(len(xy))))


def _size(points: Array) -> float:
    """Return the root mean square distance of points (N, 3) from their middle."""
    return float(np.sqrt(np.mean(np.sum((points - points.mean(axis=0))**2, axis=1))))
