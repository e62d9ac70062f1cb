"""A capture seen from where its camera stood."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.capture.colour_space import LINEAR
from bpc_perception.core.geometry import invert, transform
from bpc_perception.core.path.tangents import TYPICAL_POINTS

LENS_SLACK = 0.1  # share of the image by which a lens moves its border


@dataclass(frozen=True)
class View:
    """A capture and the pose of its camera.

    Attributes:
        capture: image, organized cloud and intrinsics.
        T_base_camera: (4, 4) pose of the camera's optical frame in the base frame.
        number: of the capture within the print.
        colour_space: of its image, one of COLOUR_SPACES.
    """

    capture: Capture
    T_base_camera: Array
    number: int = 0
    colour_space: str = LINEAR

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

    def inside(self, points: Array) -> Flags:
        """Return which of the points (N, 3) of the base frame are in the image."""
        uv = self.pixels(points)
        return np.asarray(np.isfinite(uv).all(axis=1) & self.capture.camera.contains(uv))

    def surrounds(self, points: Array, margin: float) -> Flags:
        """Return which points (N, 3) of the base frame are in view, or nearly so.

        Args:
            points: [m].
            margin: how far outside the image they may be [m].
        """
        camera = self.capture.camera
        x, y, z = transform(self.T_camera_base, points).T
        low, high = -LENS_SLACK, 1 + LENS_SLACK
        left, right = ((camera.width * share - camera.K[0, 2]) / camera.K[0, 0]
                       for share in (low, high))
        top, bottom = ((camera.height * share - camera.K[1, 2]) / camera.K[1, 1]
                       for share in (low, high))
        near: Flags = ((z > 0) & (x > left * z - margin) & (x < right * z + margin)
                       & (y > top * z - margin) & (y < bottom * z + margin))
        return near

    def pixel_size(self, points: Array) -> float:
        """Return the length of a pixel's side about where the path (N, 3) is [m]."""
        some = points[::1 + len(points) // TYPICAL_POINTS]
        distance = float(np.median(transform(self.T_camera_base, some)[:, 2]))
        return distance / self.capture.camera.focal_length
