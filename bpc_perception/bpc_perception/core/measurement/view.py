"""A capture seen from where its camera stood."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.geometry import invert, transform
from bpc_perception.core.path.tangents import TYPICAL_POINTS


@dataclass(frozen=True)
class View:
    """A capture and the pose of its camera.

    Attributes:
        capture: image, organized cloud and intrinsics.
        T_base_camera: (4, 4) pose of the camera's optical frame in the base frame.
    """

    capture: Capture
    T_base_camera: Array

    @cached_property
    def T_camera_base(self) -> Array:
        """The pose (4, 4) of the base frame in the camera's optical frame."""
        return invert(self.T_base_camera)

    @property
    def viewpoint(self) -> Array:
        """The place (3,) of the camera in the base frame [m]."""
        place: Array = self.T_base_camera[:3, 3]
        return place

    def pixels(self, points: Array) -> Array:
        """Return the pixels (N, 2) of points (N, 3) of the base frame [m]; NaN = not in front."""
        return self.capture.camera.pixels(transform(self.T_camera_base, points))

    def pixels_inside(self, points: Array) -> Array:
        """Return the pixels (K, 2) of those of the points (N, 3) that are in the image."""
        uv = self.pixels(points)
        inside: Array = uv[np.isfinite(uv).all(axis=1) & self.capture.camera.contains(uv)]
        return inside

    def pixel_size(self, points: Array) -> float:
        """Return the length of a pixel's side about where the path (N, 3) is [m]."""
        some = points[::1 + len(points) // TYPICAL_POINTS]
        distance = float(np.median(transform(self.T_camera_base, some)[:, 2]))
        return distance / self.capture.camera.focal_length
