"""The scales of a measurement: pixels on the surface, and what is steady along the path."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.geometry import invert, transform
from bpc_perception.core.path.tangents import TYPICAL

ASKED = 10  # sections within a window that tell what is steady there
WINDOW = 0.008  # length of path over which surface and light are taken as steady [m]


def pixel_size(capture: Capture, points: Array, T_base_camera: Array) -> float:
    """Length of a pixel's side about where the path (N, 3) is [m]."""
    some = points[::1 + len(points) // TYPICAL]
    distance = float(np.median(transform(invert(T_base_camera), some)[:, 2]))
    return distance / capture.camera.focal_length


def step_within_window(spacing: float) -> int:
    """From one path point to the next that is asked of what is steady within a window."""
    return max(1, round(WINDOW / ASKED / spacing))
