"""What keeps the bed below the path from being judged."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.measurement.view import View
from bpc_perception.core.profile import Cause, Status

Mask = NDArray[np.uint8]

DEPTH_REACH_PX = 2  # depth has to be known this close to a sample
AMONG_REACH_PX = 24  # an obstacle this close to the path stands among the print


def find_obstacles(view: View, bed: Plane, height: float) -> Mask:
    """Return where (H, W) something stands more than ``height`` [m] above the bed, as 255."""
    # The plane in the camera's frame, so that the cloud need not be transformed.
    normal = (view.T_base_camera[:3, :3].T @ bed.normal).astype(np.float32)
    above = view.capture.cloud @ normal + np.float32(bed.height(view.viewpoint))
    return (above > height).astype(np.uint8) * 255  # NaN is not above


def obstacle_near_path(obstacle: Mask, view: View, points: Array) -> bool:
    """Return whether an obstacle shows in the part of the image around the path (N, 3) [m]."""
    uv = view.pixels(points[view.inside(points)])
    if len(uv) == 0:
        return False
    u0, v0 = np.maximum(np.floor(uv.min(axis=0)) - AMONG_REACH_PX, 0).astype(int)
    u1, v1 = np.ceil(uv.max(axis=0)).astype(int) + AMONG_REACH_PX
    return bool(obstacle[v0:v1 + 1, u0:u1 + 1].any())


def visibility(view: View, bed: Plane, obstacle: Mask, points: Array,
               margin: int) -> Verdicts:
    """Return what keeps the bed below path points (N, 3) from being judged.

    MEASURED = nothing; NO_DATA = outside the image, or no depth around; OCCLUDED = an obstacle
    stands in front, or within the margin.

    Args:
        view: the capture.
        bed: in the base frame.
        obstacle: (H, W) 255 where an obstacle shows.
        points: (N, 3) in the base frame [m].
        margin: around obstacles [pixels].
    """
    camera = view.capture.camera
    uv = view.pixels(bed.project(points))
    inside = np.flatnonzero(np.isfinite(uv).all(axis=1) & camera.contains(uv))
    u, v = np.rint(uv[inside]).astype(np.intp).T
    result = Verdicts.all_of(len(points), Status.NO_DATA, Cause.OUTSIDE_IMAGE)
    known = dilate(np.isfinite(view.capture.cloud[..., 2]).astype(np.uint8), DEPTH_REACH_PX)
    count = len(inside)
    return result.with_part(inside, Verdicts.by_first(
        [(dilate(obstacle, margin)[v, u] > 0, Status.OCCLUDED, Cause.NONE),
         (known[v, u] > 0, Status.MEASURED, Cause.NONE)],
        Verdicts.all_of(count, Status.NO_DATA, Cause.NO_DEPTH)))


def dilate(mask: Mask, margin: int) -> Mask:
    """Return a mask (H, W) grown by a margin [pixels] on all sides."""
    return np.asarray(cv2.dilate(mask, np.ones((2 * margin + 1, 2 * margin + 1), np.uint8)),
                      np.uint8)
