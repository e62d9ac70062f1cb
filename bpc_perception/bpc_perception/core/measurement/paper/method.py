"""The published method: Zobeidi et al., IROS 2026, from capture and path to side points.

Its steps are in ``segmentation`` (Sec. III-A) and ``thickness`` (Sec. III-B). It pictures
finished prints: while something stands among the print, nothing is judged.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture, sample_cloud
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.geometry import invert, Plane, transform
from bpc_perception.core.measurement.paper.delineation import delineate
from bpc_perception.core.measurement.paper.thickness import (
    containing_contour,
    fit_plane,
    side_points,
)
from bpc_perception.core.measurement.side_points import SidePoints
from bpc_perception.core.path.tangents import tangents
from bpc_perception.core.profile import Status, StatusArray

Mask = NDArray[np.uint8]

DEPTH_RADIUS = 2  # depth must be known this near to a sample [pixels]
REACH = 24  # what stands this near to the path is among the print [pixels]


def measure_as_published(
    capture: Capture, points: Array, T_base_camera: Array, bed: Plane, config: ThicknessConfig,
) -> tuple[SidePoints, StatusArray, Array]:
    """Side points, status (N,) and sigma (N,) of path points (N, 3); see ``measure``."""
    contours = contours_3d(capture, T_base_camera, config)
    viewpoint = T_base_camera[:3, 3]
    try:
        plane = fit_plane(np.concatenate(contours), viewpoint)
    except ValueError:  # nothing delineated
        plane = bed
    containing = containing_contour(
        plane.coordinates(points), [plane.coordinates(contour) for contour in contours])
    sides = side_points(points, tangents(points), contours, containing, plane.normal)
    status = np.where(containing < 0, Status.GAP, Status.MEASURED).astype(np.uint8)
    one_sided = np.isnan(sides.left_distance + sides.right_distance)
    status[(status == Status.MEASURED) & one_sided] = Status.LOW_CONFIDENCE
    obstacle = obstacles(capture, bed, T_base_camera, config.obstacle_height)
    if among(obstacle, capture, points, T_base_camera):
        # The outline of what stands there joins the print's.
        status[:] = Status.LOW_CONFIDENCE
    seen = visibility(capture, bed, obstacle, points, T_base_camera,
                      round(config.obstacle_margin))
    status = np.where(seen == Status.MEASURED, status, seen)
    distance = np.linalg.norm(points - viewpoint, axis=1)
    return sides, status, pixel_edge_sigma(distance, capture.camera.focal_length)


def contours_3d(capture: Capture, T_base_camera: Array,
                config: ThicknessConfig) -> list[Array]:
    """The fused contours (N_i, 3) in the base frame [m]; vertices without a point are left out."""
    contours = []
    for contour in delineate(capture.image, config.segmentation).fused:
        points = sample_cloud(capture.cloud, contour.astype(np.float64))
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) >= 3:
            contours.append(transform(T_base_camera, points))
    return contours


def pixel_edge_sigma(distance: Array, focal_length: float) -> Array:
    """1-sigma uncertainty of a width between two edges known to a whole pixel only [m].

    Each edge is spread evenly over one pixel, whose side is distance / focal_length.
    """
    return distance / focal_length * np.sqrt(2 / 12)


def obstacles(capture: Capture, bed: Plane, T_base_camera: Array, height: float) -> Mask:
    """Where (H, W) something stands more than ``height`` [m] above the bed, as 255."""
    # The plane in the camera frame, so that the cloud need not be transformed.
    normal = (T_base_camera[:3, :3].T @ bed.normal).astype(np.float32)
    above = capture.cloud @ normal + np.float32(bed.height(T_base_camera[:3, 3]))
    return (above > height).astype(np.uint8) * 255  # NaN is not above


def visibility(capture: Capture, bed: Plane, obstacle: Mask, points: Array,
               T_base_camera: Array, margin: int) -> StatusArray:
    """What keeps the bed below path points (N, 3) from being judged, as Status (N,).

    MEASURED = nothing; NO_DATA = outside the image or no depth around; OCCLUDED = something
    stands in front.
    """
    uv = capture.camera.pixels(transform(invert(T_base_camera), bed.project(points)))
    inside = np.flatnonzero(np.isfinite(uv).all(axis=1) & capture.camera.contains(uv))
    u, v = np.rint(uv[inside]).astype(np.intp).T
    status = np.full(len(points), Status.NO_DATA, np.uint8)
    side = 2 * DEPTH_RADIUS + 1
    kernel = np.ones((side, side), np.uint8)
    known = cv2.dilate(np.isfinite(capture.cloud[..., 2]).astype(np.uint8), kernel)
    status[inside[known[v, u] > 0]] = Status.MEASURED
    status[inside[near(obstacle, margin)[v, u] > 0]] = Status.OCCLUDED
    return status


def among(obstacle: Mask, capture: Capture, points: Array, T_base_camera: Array) -> bool:
    """Whether an obstacle shows in the part of the image that path points (N, 3) take up."""
    uv = capture.camera.pixels(transform(invert(T_base_camera), points))
    uv = uv[np.isfinite(uv).all(axis=1) & capture.camera.contains(uv)]
    if len(uv) == 0:
        return False
    u0, v0 = np.maximum(np.floor(uv.min(axis=0)) - REACH, 0).astype(int)
    u1, v1 = np.ceil(uv.max(axis=0)).astype(int) + REACH
    return bool(obstacle[v0:v1 + 1, u0:u1 + 1].any())


def near(mask: Mask, margin: int) -> Mask:
    """The mask grown by ``margin`` pixels on all sides."""
    return np.asarray(cv2.dilate(mask, np.ones((2 * margin + 1, 2 * margin + 1), np.uint8)),
                      np.uint8)
