"""Intrinsics, pose and rays of the synthetic camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import PinholeCamera

# A Zivid 2 M70 at its full size; its captures are free of distortion.
M70_WIDTH_PX, M70_HEIGHT_PX = 1944, 1200
M70_FOCAL_LENGTH_PX = 1781.45
M70_CENTRE_PX = (990.5, 585.8)


@dataclass(frozen=True, eq=False)
class View:
    """A camera and the pose of its optical frame.

    Attributes:
        camera: intrinsics.
        T_base_camera: (4, 4) pose of the optical frame in the base frame.
    """

    camera: PinholeCamera
    T_base_camera: Array


def zivid_m70(width: int = M70_WIDTH_PX, height: int = M70_HEIGHT_PX,
              scale: float = 1.0) -> PinholeCamera:
    """Return the intrinsics of a Zivid 2 M70, reduced to a smaller image.

    The full image is resampled by ``scale`` first. Then a window of width x height pixels is cut
    out around the principal point, as far as the image reaches.

    Raises:
        ValueError: the window is larger than the resampled image.
    """
    full = np.rint(scale * np.array((M70_WIDTH_PX, M70_HEIGHT_PX)))
    if width > full[0] or height > full[1]:
        raise ValueError(f'window: expected at most {full[0]:g} x {full[1]:g} pixels at scale '
                         f'{scale:g}, found {width} x {height}')
    # The outer border of the first pixel is at -0.5 before and after resampling.
    centre = (np.array(M70_CENTRE_PX) + 0.5) * scale - 0.5
    size = np.array((width, height))
    cx, cy = centre - np.clip(np.rint(centre - (size - 1) / 2), 0, full - size)
    focal = scale * M70_FOCAL_LENGTH_PX
    K = np.array(((focal, 0.0, cx), (0.0, focal, cy), (0.0, 0.0, 1.0)))
    return PinholeCamera(K, np.zeros(5), width, height)


def look_at(eye: Array, target: Array, right: Array) -> Array:
    """Return the pose (4, 4) of an optical frame at ``eye`` that looks at ``target``, (3,) [m].

    The image's x axis points along ``right`` (3,), as far as the direction of view allows.
    """
    z = (target - eye) / np.linalg.norm(target - eye)
    y = np.cross(z, right)
    y /= np.linalg.norm(y)
    pose = np.eye(4)
    pose[:3, :3] = np.stack((np.cross(y, z), y, z), axis=1)
    pose[:3, 3] = eye
    return pose


def rays(camera: PinholeCamera, uv: Array) -> Array:
    """Return the directions (..., 3) of pixels (..., 2) in the optical frame, of depth z = 1.

    Raises:
        ValueError: the camera has distortion.
    """
    if np.any(camera.distortion):
        raise ValueError('camera: expected no distortion, as in captures of the vendor, '
                         f'found {camera.distortion}')
    xy = (uv - camera.K[:2, 2]) / camera.K[(0, 1), (0, 1)]
    return np.concatenate((xy, np.ones((*xy.shape[:-1], 1))), axis=-1)


def pixel_rays(camera: PinholeCamera) -> Array:
    """Return the directions (H, W, 3) of all pixels in the optical frame, of depth z = 1.

    Raises:
        ValueError: the camera has distortion.
    """
    uv = np.stack(np.meshgrid(np.arange(camera.width), np.arange(camera.height)), axis=-1)
    return rays(camera, uv.astype(float))
