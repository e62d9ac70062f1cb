"""One capture of a structured-light camera: image, organized cloud and intrinsics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array, Flags, Floats, Index

NEAREST_DEPTH_M = 1e-6  # what is nearer is not in front of the camera
# Around a place on a path, pixels are looked up on a grid, to see the bed on either side.
AROUND_PX = 24
AROUND_GRID = 5  # places along a side of the grid
GRID_POINTS = 64  # along the longer side, that tell whether a cloud fits to the intrinsics


@dataclass(frozen=True)
class PinholeCamera:
    """Intrinsics of a camera; its optical frame is x right, y down, z forward.

    Attributes:
        K: (3, 3) matrix of focal lengths and principal point [pixels].
        distortion: (5,) plumb-bob coefficients k1, k2, p1, p2, k3; the last ones may be missing,
            and k4, k5, k6 of the rational model may follow.
        width, height: size of the image [pixels].
    """

    K: Array
    distortion: Array
    width: int
    height: int

    @property
    def focal_length(self) -> float:
        """Mean focal length [pixels]."""
        return float(self.K[0, 0] + self.K[1, 1]) / 2

    def pixels(self, points: Array) -> Array:
        """Return the pixels (..., 2) as (u, v) of points (..., 3) in the camera frame [m].

        Pixel centres have integer coordinates. Points that are not in front of the camera, or not
        finite, give NaN. The result is that of cv2.projectPoints, which takes ten times as long
        since it also computes derivatives.
        """
        z = points[..., 2]
        z = np.where((z > NEAREST_DEPTH_M) & (z < np.inf), z, np.nan)
        x, y = points[..., 0] / z, points[..., 1] / z
        if self.distortion.any():
            x, y = self._distort(x, y)
        uv = np.stack((self.K[0, 0] * x + self.K[0, 1] * y + self.K[0, 2],
                       self.K[1, 1] * y + self.K[1, 2]), axis=-1)
        uv[~np.isfinite(uv[..., 0] + uv[..., 1])] = np.nan
        return uv

    def _distort(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return where the lens moves places x, y of the plane z = 1.

        [OpenCV, calib3d: distortion]
        """
        k1, k2, p1, p2, k3, k4, k5, k6 = np.pad(self.distortion, (0, 8 - len(self.distortion)))
        r2 = x * x + y * y
        radial = ((1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6))))
        return (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y)

    def contains(self, uv: NDArray[np.floating[Any]]) -> Flags:
        """Return which pixels (..., 2) lie between the outermost pixel centres of the image."""
        u, v = uv[..., 0], uv[..., 1]
        inside: Flags = (
            (u >= 0) & (u <= self.width - 1) & (v >= 0) & (v <= self.height - 1))
        return inside


@dataclass(frozen=True)
class Capture:
    """What the camera delivers at once; pixel (v, u) of the image is point (v, u) of the cloud.

    Raises ValueError if image, cloud and intrinsics are not of one size.

    Attributes:
        stamp_ns: time of the capture [ns].
        frame_id: name of the camera's optical frame.
        image: (H, W, 3) RGB, uint8.
        cloud: (H, W, 3) points in the camera's optical frame [m], float32; NaN = none.
        camera: intrinsics belonging to image and cloud.
        snr: (H, W) signal-to-noise ratio of the points, float32; None = the camera gives none.
    """

    stamp_ns: int
    frame_id: str
    image: NDArray[np.uint8]
    cloud: Floats
    camera: PinholeCamera
    snr: Floats | None = None

    def __post_init__(self) -> None:
        shape = (self.camera.height, self.camera.width, 3)
        if self.image.shape != shape or self.cloud.shape != shape:
            raise ValueError(f'image and cloud: expected shape {shape} as in the camera info, '
                             f'found {self.image.shape} and {self.cloud.shape}')


def pixel_deviation(cloud: Array | Floats, camera: PinholeCamera) -> float:
    """Return how far from their own pixels the camera sees points of a cloud [pixels].

    It is the median over a grid of points of the cloud (H, W, 3) [m]; NaN without points. It is
    large if intrinsics and cloud belong to different captures, resolutions or orders of rows.
    """
    step = max(max(cloud.shape[:2]) // GRID_POINTS, 1)
    uv = camera.pixels(cloud[::step, ::step].astype(np.float64))
    v, u = np.mgrid[0:cloud.shape[0]:step, 0:cloud.shape[1]:step]
    distance = np.hypot(uv[..., 0] - u, uv[..., 1] - v)
    finite = distance[np.isfinite(distance)]
    return float(np.median(finite)) if len(finite) else float('nan')


def pixels_around(uv: Array, camera: PinholeCamera) -> tuple[Index, Index]:
    """Return columns and rows (K,) of pixels on a grid around each of some places uv (N, 2)."""
    steps = np.linspace(-AROUND_PX, AROUND_PX, AROUND_GRID)
    grid = uv[:, None, None] + np.stack(np.meshgrid(steps, steps), axis=-1)
    u, v = np.rint(grid).astype(np.intp).reshape(-1, 2).T
    inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    return u[inside], v[inside]


def sample_cloud(cloud: Floats, uv: Array) -> Array:
    """Return the points (N, 3) of an organized cloud (H, W, 3) [m] at sub-pixel places uv (N, 2).

    They are interpolated bilinearly between the four pixels around. NaN outside the image, and
    where one of the four that carries weight has no point.
    """
    height, width = cloud.shape[:2]
    inside: Flags = np.all((uv >= 0) & (uv <= (width - 1, height - 1)), axis=1)
    safe = np.where(inside[:, None], uv, 0.0)
    base = np.minimum(safe.astype(np.intp), np.maximum((width - 2, height - 2), 0))
    u, v = base.T
    fu, fv = (safe - base).T
    points = np.zeros((len(uv), 3))
    for dv, du, weight in ((0, 0, (1 - fv) * (1 - fu)), (0, 1, (1 - fv) * fu),
                           (1, 0, fv * (1 - fu)), (1, 1, fv * fu)):
        corner = cloud[np.minimum(v + dv, height - 1), np.minimum(u + du, width - 1)]
        points += np.where(weight[:, None] > 0, corner * weight[:, None], 0.0)
    points[~inside] = np.nan
    return points
