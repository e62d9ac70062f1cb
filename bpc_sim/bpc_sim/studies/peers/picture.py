"""A scene as the other tools take it: a picture of a plane bed, and the path in it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import invert, transform
from bpc_sim.stress.stress_scene import StressScene

EDGE_REACH_M = 4e-3  # from the path to the farthest edge, as in our own method
CUT_STEP_PX = 0.25  # along a cut
SMALLEST_REGION_PX = 64  # smaller holes and specks of a mask count as noise

Image = NDArray[np.uint8]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture of a plane bed, and the path in it.

    Attributes:
        image: (H, W, 3) RGB.
        uv: (N, 2) pixels of the path.
        normal: (N, 2) unit vectors across the path in the image.
        pixel: length of a pixel's side on the bed [m].
    """

    image: Image
    uv: Array
    normal: Array
    pixel: float

    @property
    def reach(self) -> float:
        """Distance from the path within which an edge may be [pixels]."""
        return EDGE_REACH_M / self.pixel

    @cached_property
    def grey(self) -> Image:
        """The smoothed channel (H, W) in which ink and bed differ most; ink is bright."""
        channels = cv2.split(cv2.GaussianBlur(self.image, (0, 0), 1.0))
        best = np.asarray(max(channels, key=separability), np.uint8)
        level, _ = cv2.threshold(best, 0, 1, cv2.THRESH_OTSU)
        return best if np.median(self.at(best)) > level else 255 - best

    @cached_property
    def level(self) -> float:
        """Otsu's threshold of ``grey``."""
        return float(cv2.threshold(self.grey, 0, 1, cv2.THRESH_OTSU)[0]) + 0.5

    @cached_property
    def mask(self) -> Mask:
        """Ink (H, W) by Otsu's threshold, without small holes and specks."""
        return remove_specks(self.grey > self.level)

    def at(self, values: NDArray[Any]) -> Array:
        """Return values (H, W) at the path (N,)."""
        return sample(values, self.uv, order=0)

    def cuts(self, values: NDArray[Any]) -> Array:
        """Return values (H, W) along the cuts across the path, (N, M) from right to left."""
        offset = np.arange(-self.reach, self.reach + CUT_STEP_PX, CUT_STEP_PX)
        return sample(values, self.uv[:, None] + offset[:, None] * self.normal[:, None], order=1)


def picture_of(scene: StressScene) -> Picture:
    """Return the picture of a scene on a plane bed seen from straight above."""
    uv = scene.capture.camera.pixels(transform(invert(scene.T_base_camera), scene.points))
    tangent = np.gradient(uv, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    return Picture(scene.capture.image, uv, tangent[:, ::-1] * (1, -1), scene.pixel)


def sample(values: NDArray[Any], uv: Array, order: int) -> Array:
    """Return values (H, W) at pixels uv (..., 2), interpolated with splines of an order."""
    return np.asarray(map_coordinates(values.astype(np.float64), (uv[..., 1], uv[..., 0]),
                                      order=order, mode='nearest'))


def separability(channel: NDArray[Any]) -> float:
    """Return Otsu's measure: the share of a channel's variance between its two classes."""
    level, _ = cv2.threshold(channel, 0, 1, cv2.THRESH_OTSU)
    above = channel > level
    share = float(above.mean())
    if share in (0.0, 1.0):
        return 0.0
    step = float(channel[above].mean() - channel[~above].mean())
    return share * (1 - share) * step**2 / float(channel.var())


def remove_specks(mask: Mask) -> Mask:
    """Return a mask (H, W) without holes and specks smaller than SMALLEST_REGION_PX."""
    cleaned = mask.astype(np.uint8)
    for inverted in (0, 1):  # specks, holes
        _, label, stats, _ = cv2.connectedComponentsWithStats(cleaned ^ inverted)
        small = stats[:, cv2.CC_STAT_AREA] < SMALLEST_REGION_PX
        small[0] = False
        cleaned[small[label]] = inverted
    return cleaned > 0
