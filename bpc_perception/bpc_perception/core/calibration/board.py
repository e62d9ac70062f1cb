"""A calibration board in a capture: its corners in the image and in space.

The board's frame has its origin at the outer corner of the first square, x along a row of
squares, y along a column, and z away from who looks at its face.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.capture.capture import Capture, PinholeCamera

FEWEST_CORNERS = 8
# Of the pixels among the corners so many need a depth; else the cloud says too little.
LEAST_DEPTH = 0.3
PLANE_ROUNDS = 3  # of fitting the board's plane without what lies off it
SCALE_TOLERANCE = 0.01  # by which squares in the cloud may differ from what was given


@dataclass(frozen=True)
class Board:
    """A checkerboard, or a ChArUco board if it has markers.

    Attributes:
        columns, rows: number of squares; of a checkerboard one is even and the other odd, since
            otherwise nobody can tell it from itself turned by 180 degrees.
        square: side of a square [m].
        marker: side of a marker [m]; 0 = checkerboard.
        dictionary: of the markers, a name of OpenCV.
    """

    columns: int
    rows: int
    square: float
    marker: float = 0.0
    dictionary: str = 'DICT_4X4_50'

    def __post_init__(self) -> None:
        if min(self.columns, self.rows) < 4 or not self.square > 0:
            raise CalibrationError('board: expected 4 x 4 squares or more of a size, found '
                                   f'{self.columns} x {self.rows} of {self.square * 1e3:g} mm')
        if not self.marker and (self.columns + self.rows) % 2 == 0:
            raise CalibrationError('board: expected an even and an odd number of squares, since '
                                   'others look the same upside down, found '
                                   f'{self.columns} x {self.rows}')
        if self.marker and not 0 < self.marker < self.square:
            raise CalibrationError(f'board: expected markers smaller than the squares of '
                                   f'{self.square * 1e3:g} mm, found {self.marker * 1e3:g} mm')
        if self.marker and not hasattr(cv2.aruco, self.dictionary):
            raise CalibrationError('board: expected a dictionary of OpenCV such as DICT_4X4_50, '
                                   f'found {self.dictionary}')

    def charuco(self) -> Any:
        """The board as OpenCV knows it."""
        markers = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))
        return cv2.aruco.CharucoBoard((self.columns, self.rows), self.square, self.marker, markers)

    @property
    def corners(self) -> Array:
        """The inner corners (K, 3), row by row, in the board's frame [m]."""
        y, x = np.mgrid[1:self.rows, 1:self.columns]
        return self.square * np.stack((x, y, np.zeros_like(x)), axis=-1).reshape(-1, 3)


@dataclass(frozen=True)
class Sighting:
    """A board found in a capture.

    Attributes:
        on_board: (N, 3) corners in the board's frame [m].
        uv: (N, 2) the same in the image [pixels].
        in_camera: (N, 3) the same in the camera's optical frame, from the cloud [m]; NaN where
            the cloud says too little.
        scale: size of the squares in the cloud per that given; NaN as above.
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
    """Find a board. Raises CalibrationError where it is not seen, or has another size."""
    grey = np.asarray(cv2.cvtColor(capture.image, cv2.COLOR_RGB2GRAY), np.uint8)
    ids, uv = (_charuco if board.marker else _checkerboard)(grey, board)
    if len(ids) < FEWEST_CORNERS:
        raise CalibrationError(f'board: expected {FEWEST_CORNERS} corners or more, '
                               f'found {len(ids)}')
    on_board = board.corners[ids]
    in_camera = _lift(capture, uv)
    scale = float('nan')
    if np.isfinite(in_camera).all():
        scale = _size(in_camera) / _size(on_board)
        if abs(scale - 1) > SCALE_TOLERANCE:
            raise CalibrationError(
                f'board: expected squares of {board.square * 1e3:g} mm, found '
                f'{board.square * scale * 1e3:.4g} mm in the cloud')
    return Sighting(on_board, uv, in_camera, scale, capture.camera)


def _checkerboard(grey: NDArray[np.uint8], board: Board) -> tuple[NDArray[np.intp], Array]:
    size = (board.columns - 1, board.rows - 1)
    found, corners = cv2.findChessboardCorners(
        grey, size, flags=cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE)
    if not found:  # the other detector is slower, but stands more shade and blur
        found, corners = cv2.findChessboardCornersSB(grey, size,
                                                     flags=cv2.CALIB_CB_NORMALIZE_IMAGE)
    if not found:
        return np.empty(0, np.intp), np.empty((0, 2))
    grid = _refine(grey, corners.reshape(size[1], size[0], 2))
    across, down = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    if across[0] * down[1] - across[1] * down[0] < 0:  # seen in a mirror, as it were
        grid = grid[:, ::-1]
    if not _begins_dark(grey, grid):
        grid = grid[::-1, ::-1]
    return np.arange(size[0] * size[1]), grid.reshape(-1, 2)


def _refine(grey: NDArray[np.uint8], grid: NDArray[Any]) -> Array:
    """Corners (R, C, 2) to a fraction of a pixel, from a third of a square around each.

    On synthetic boards half as far off as the corners of ``findChessboardCornersSB`` with
    ``CALIB_CB_ACCURACY``.
    """
    pitch = min(float(np.linalg.norm(np.diff(grid, axis=axis), axis=2).min()) for axis in (0, 1))
    window = max(int(pitch / 3), 2)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 40, 1e-3)
    refined = cv2.cornerSubPix(grey, np.ascontiguousarray(grid, np.float32).reshape(-1, 1, 2),
                               (window, window), (-1, -1), criteria)
    return np.asarray(refined, np.float64).reshape(grid.shape)


def _begins_dark(grey: NDArray[np.uint8], grid: Array) -> bool:
    """Whether the square between the first corners is dark, as the board's frame has it."""
    centres = (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:]) / 4
    column, row = np.rint(centres).astype(np.intp).transpose(2, 0, 1)
    levels = grey[row, column].astype(np.float64)
    even = np.add.outer(np.arange(len(levels)), np.arange(levels.shape[1])) % 2 == 0
    return bool(levels[even].mean() < levels[~even].mean())


def _charuco(grey: NDArray[np.uint8], board: Board) -> tuple[NDArray[np.intp], Array]:
    found: tuple[Any, ...] = cv2.aruco.CharucoDetector(board.charuco()).detectBoard(grey)
    corners, ids = found[:2]
    if ids is None:
        return np.empty(0, np.intp), np.empty((0, 2))
    return np.ravel(ids).astype(np.intp), np.reshape(corners, (-1, 2)).astype(np.float64)


def directions(camera: PinholeCamera, uv: Array) -> Array:
    """Viewing rays (N, 3) of pixels (N, 2), of depth z = 1."""
    xy = cv2.undistortPoints(uv.reshape(-1, 1, 2), camera.K, camera.distortion).reshape(-1, 2)
    return np.column_stack((xy, np.ones(len(xy))))


def _lift(capture: Capture, uv: Array) -> Array:
    """Corners (N, 3) where their rays meet the board's plane; NaN without enough depth.

    The plane is that of all points between the corners, so that their noise goes out, and no
    point at a corner itself is needed: at the border of dark and light depth is at its worst.
    """
    nothing = np.full((len(uv), 3), np.nan)
    mask = np.zeros(capture.image.shape[:2], np.uint8)
    cv2.fillConvexPoly(mask, cv2.convexHull(np.rint(uv).astype(np.int32)), 1)
    points = capture.cloud[mask > 0].astype(np.float64)
    finite = np.isfinite(points).all(axis=1)
    if finite.mean() < LEAST_DEPTH:
        return nothing
    points = points[finite]
    keep = np.ones(len(points), bool)
    for _ in range(PLANE_ROUNDS):
        centre = points[keep].mean(axis=0)
        _, axes = np.linalg.eigh(np.cov((points[keep] - centre).T))
        normal = axes[:, 0]  # of the smallest eigenvalue
        height = (points - centre) @ normal
        keep = np.abs(height) <= 3 * max(1.4826 * float(np.median(np.abs(height))), 1e-6)
    rays = directions(capture.camera, uv)
    return rays * (normal @ centre / (rays @ normal))[:, None]


def _size(points: Array) -> float:
    """Root mean square distance of points (N, 3) from their middle."""
    return float(np.sqrt(np.mean(np.sum((points - points.mean(axis=0))**2, axis=1))))
