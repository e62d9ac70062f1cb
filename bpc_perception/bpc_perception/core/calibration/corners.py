"""The corners of a calibration board in an image."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.calibration.board import Board

Grey = NDArray[np.uint8]


def find_corners(image: NDArray[np.uint8], board: Board) -> tuple[Index, Array]:
    """Return which inner corners of a board (N,) are seen in an RGB image (H, W, 3), and where.

    The first are indices into ``Board.corners``, the second are pixels (N, 2) as (u, v). Both are
    empty if the board is not found.
    """
    grey = np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.uint8)
    return _charuco(grey, board) if board.marker else _checkerboard(grey, board)


def _checkerboard(grey: Grey, board: Board) -> tuple[Index, Array]:
    found = _grid(grey, (board.columns - 1, board.rows - 1))
    if found is None:
        return np.empty(0, np.intp), np.empty((0, 2))
    grid = _oriented(grey, _refined(grey, found)).reshape(-1, 2)
    return np.arange(len(grid)), grid


def _grid(grey: Grey, size: tuple[int, int]) -> NDArray[Any] | None:
    """Return the inner corners (R, C, 2) of a checkerboard with size (C, R); None = not found."""
    found, corners = cv2.findChessboardCorners(
        grey, size, flags=cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE)
    if not found:  # the other detector is slower, but tolerates more shade and blur
        found, corners = cv2.findChessboardCornersSB(grey, size,
                                                     flags=cv2.CALIB_CB_NORMALIZE_IMAGE)
    return corners.reshape(size[1], size[0], 2) if found else None


def _refined(grey: Grey, grid: NDArray[Any]) -> Array:
    """Return corners (R, C, 2) to a fraction of a pixel, from a third of a square around each.

    On synthetic boards they are half as far off as the corners of ``findChessboardCornersSB`` with
    ``CALIB_CB_ACCURACY``.
    """
    pitch = min(float(np.linalg.norm(np.diff(grid, axis=axis), axis=2).min()) for axis in (0, 1))
    window = max(int(pitch / 3), 2)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 40, 1e-3)
    refined = cv2.cornerSubPix(grey, np.ascontiguousarray(grid, np.float32).reshape(-1, 1, 2),
                               (window, window), (-1, -1), criteria)
    return np.asarray(refined, np.float64).reshape(grid.shape)


def _oriented(grey: Grey, grid: Array) -> Array:
    """Return corners (R, C, 2) in the order in which the board's frame has them."""
    across, down = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    if across[0] * down[1] - across[1] * down[0] < 0:  # as if seen in a mirror
        grid = grid[:, ::-1]
    return grid if _begins_dark(grey, grid) else grid[::-1, ::-1]


def _begins_dark(grey: Grey, grid: Array) -> bool:
    """Return whether the square between the first corners is dark, as in the board's frame."""
    centres = (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:]) / 4
    column, row = np.rint(centres).astype(np.intp).transpose(2, 0, 1)
    levels = grey[row, column].astype(np.float64)
    even = np.add.outer(np.arange(len(levels)), np.arange(levels.shape[1])) % 2 == 0
    return bool(levels[even].mean() < levels[~even].mean())


def _charuco(grey: Grey, board: Board) -> tuple[Index, Array]:
    found: tuple[Any, ...] = cv2.aruco.CharucoDetector(board.charuco()).detectBoard(grey)
    corners, ids = found[:2]
    if ids is None:
        return np.empty(0, np.intp), np.empty((0, 2))
    return np.ravel(ids).astype(np.intp), np.reshape(corners, (-1, 2)).astype(np.float64)
