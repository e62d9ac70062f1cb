"""A capture of a plane bed, seen from straight above."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture, PinholeCamera

# From the camera to the plane: a float32 without rounding, so that the cloud's depth is exact.
CAMERA_DISTANCE_M = 0.5


def planar_capture(image: NDArray[np.uint8], pixel_size: float,
                   stamp_ns: int = 0) -> tuple[Capture, Array]:
    """Return a capture of the plane z = 0 of the base frame, by a pinhole straight above it.

    Args:
        image: (H, W, 3) RGB.
        pixel_size: length of a pixel's side on the plane [m].
        stamp_ns: stamp of the capture [ns].

    Returns:
        The capture, whose cloud lies exactly on the plane, and T_base_camera (4, 4).
    """
    height, width = image.shape[:2]
    distance = CAMERA_DISTANCE_M
    u0, v0 = (width - 1) / 2, (height - 1) / 2
    focal = distance / pixel_size
    K = np.array(((focal, 0.0, u0), (0.0, focal, v0), (0.0, 0.0, 1.0)))
    v, u = np.mgrid[0:height, 0:width]
    cloud = np.stack(((u - u0) * pixel_size, (v - v0) * pixel_size,
                      np.full(u.shape, distance)), axis=-1).astype(np.float32)
    T_base_camera = np.diag((1.0, -1.0, -1.0, 1.0))
    T_base_camera[2, 3] = distance
    camera = PinholeCamera(K, np.zeros(5), width, height)
    return Capture(stamp_ns, 'camera_optical_frame', image, cloud, camera), T_base_camera
