"""A capture of a calibration board."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.board import Board
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.geometry import invert, transform
from bpc_sim.scene.camera import rays, View

PRINT_PX_PER_MM = 20  # pixels of the printed pattern
SUPERSAMPLING = 4  # rays per pixel side
WHITE_MARGIN_M = 0.01  # white around the squares
DARK_LEVEL, WHITE_LEVEL, TABLE_LEVEL = 40.0, 210.0, 120.0  # grey levels


def pattern(board: Board) -> NDArray[np.uint8]:
    """Return the printed board; its origin is the outer corner of the first pixel."""
    pixels = round(board.square * 1e3 * PRINT_PX_PER_MM)
    size = (board.columns * pixels, board.rows * pixels)
    if board.marker:
        return np.asarray(board.charuco().generateImage(size), np.uint8)
    row, column = np.mgrid[0:board.rows, 0:board.columns]
    # The square to the right of and below the first inner corner is dark.
    light = np.where((row + column) % 2 == 0, 0, 255).astype(np.uint8)
    return np.kron(light, np.ones((pixels, pixels), np.uint8))


def capture_board(board: Board, T_base_board: Array, view: View, rng: np.random.Generator,
                  stamp_ns: int = 0, image_noise: float = 2.0, depth_noise: float = 1e-4,
                  blur: float = 0.7) -> Capture:
    """Return a capture of a board with nothing else around it.

    Args:
        board: the board.
        T_base_board: (4, 4) pose of the board.
        view: camera and pose.
        rng: source of the noise.
        stamp_ns: stamp of the capture [ns].
        image_noise: standard deviation of each pixel [grey levels].
        depth_noise: standard deviation of each point along its ray, relative to its depth and
            per metre of distance [1/m].
        blur: standard deviation of the lens' point spread [pixels].
    """
    T_camera_board = invert(view.T_base_camera) @ T_base_board
    camera = view.camera
    light = _grey_levels(board, T_camera_board, camera)
    light = np.asarray(cv2.GaussianBlur(light, (0, 0), blur), np.float64)
    grey = np.clip(np.rint(light + rng.normal(0, image_noise, light.shape)), 0, 255)
    u, v = np.arange(camera.width, dtype=float), np.arange(camera.height, dtype=float)
    uv = np.stack(np.meshgrid(u, v), axis=-1)
    on_board = _intersect_board(T_camera_board, rays(camera, uv))
    cloud = transform(T_camera_board, on_board)
    cloud *= 1 + rng.normal(0, depth_noise, cloud.shape[:2])[..., None] * cloud[..., 2:]
    cloud[~_is_on_board(board, on_board)] = np.nan
    image = np.repeat(grey[..., None], 3, axis=2).astype(np.uint8)
    return Capture(stamp_ns, 'zivid_optical_frame', image, cloud.astype(np.float32), camera)


def _intersect_board(T_camera_board: Array, directions: Array) -> Array:
    """Return where rays (..., 3) of the camera meet the board's plane, in the board's frame."""
    T_board_camera = invert(T_camera_board)
    slopes = directions @ T_board_camera[:3, :3].T
    eye = T_board_camera[:3, 3]
    return eye - slopes * (eye[2] / slopes[..., 2])[..., None]


def _is_on_board(board: Board, points: Array) -> NDArray[np.bool_]:
    """Tell which points (..., 3) of the board's frame lie on the board or its margin."""
    x, y = points[..., 0], points[..., 1]
    far = np.array((board.columns, board.rows)) * board.square + WHITE_MARGIN_M
    inside: NDArray[np.bool_] = (
        (x > -WHITE_MARGIN_M) & (y > -WHITE_MARGIN_M) & (x < far[0]) & (y < far[1]))
    return inside


def _grey_levels(board: Board, T_camera_board: Array, camera: PinholeCamera) -> Array:
    """Return the grey level (H, W) of each pixel, its mean over the pixel's area."""
    border = round(WHITE_MARGIN_M * 1e3 * PRINT_PX_PER_MM)
    levels = DARK_LEVEL + (WHITE_LEVEL - DARK_LEVEL) / 255 * pattern(board).astype(np.float32)
    printed = cv2.copyMakeBorder(levels, border, border, border, border,
                                 cv2.BORDER_CONSTANT, value=WHITE_LEVEL)
    # From pixels of the print to the board's plane, from there to the image and to its fine
    # pixels. A pixel's centre has whole coordinates, so its corner is half a pixel before.
    pitch = 1e-3 / PRINT_PX_PER_MM
    start = (0.5 - border) * pitch
    to_board = np.array(((pitch, 0, start), (0, pitch, start), (0, 0, 1.0)))
    to_image = camera.K @ T_camera_board[:3, (0, 1, 3)]
    shift = (SUPERSAMPLING - 1) / 2
    to_fine = np.array(((SUPERSAMPLING, 0, shift), (0, SUPERSAMPLING, shift), (0, 0, 1.0)))
    size = (SUPERSAMPLING * camera.width, SUPERSAMPLING * camera.height)
    fine = cv2.warpPerspective(printed, to_fine @ to_image @ to_board, size,
                               flags=cv2.INTER_LINEAR, borderValue=TABLE_LEVEL)
    return np.asarray(cv2.resize(fine, (camera.width, camera.height),
                                 interpolation=cv2.INTER_AREA), np.float64)
