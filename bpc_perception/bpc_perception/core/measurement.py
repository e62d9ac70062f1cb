"""From one capture and the path to a thickness profile."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.capture import Capture, sample_cloud
from bpc_perception.core.config import ThicknessConfig, VisibilityConfig
from bpc_perception.core.geometry import Array, invert, Plane, transform
from bpc_perception.core.path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.segmentation import delineate
from bpc_perception.core.thickness import (
    containing_contour,
    fit_plane,
    side_points,
    SidePoints,
    tangents,
)

StatusArray = NDArray[np.uint8]


class MeasurementError(ValueError):
    """Nothing can be measured in a capture; the message says why."""


def measure(capture: Capture, path: DepositionPath, T_base_camera: Array,
            config: ThicknessConfig, number: int = 0) -> ThicknessProfile:
    """Thickness at every point of the path that the nozzle had passed when captured.

    Args:
        capture: image and organized cloud of one moment.
        path: the print's path, in the robot base frame.
        T_base_camera: (4, 4) pose of the camera's optical frame in the base frame.
        config: how to measure.
        number: number of the capture within the print.

    Raises:
        MeasurementError: the path is empty, or nothing was found that spans a surface.
    """
    started = time.perf_counter()
    path = path.until(capture.stamp_ns)
    if len(path) < 2:
        raise MeasurementError(f'path: expected 2 points or more before the capture, '
                               f'found {len(path)}')
    sides, status, sigma = paper_method(capture, path.points, T_base_camera, config)

    measured = status == Status.MEASURED
    for values in (sides.left, sides.right, sides.left_distance, sides.right_distance, sigma):
        values[~measured] = np.nan
    thickness = np.linalg.norm(sides.left - sides.right, axis=1)
    thickness[status == Status.GAP] = 0.0
    return ThicknessProfile(
        stamp_ns=capture.stamp_ns, print_id=path.print_id, print_start_ns=path.start_ns,
        capture=number, method=config.method, time=path.time, arc_length=path.arc_length,
        points=path.points, extruding=path.extruding, status=status, thickness=thickness,
        sigma=sigma, left=sides.left_distance, right=sides.right_distance,
        left_points=sides.left, right_points=sides.right,
        processing_time=time.perf_counter() - started)


def paper_method(capture: Capture, points: Array, T_base_camera: Array,
                 config: ThicknessConfig) -> tuple[SidePoints, StatusArray, Array]:
    """The published method: side points, status (N,) and sigma (N,) of path points (N, 3)."""
    contours = contours_3d(capture, T_base_camera, config)
    viewpoint = T_base_camera[:3, 3]
    try:
        plane = fit_plane(np.concatenate(contours) if contours else np.empty((0, 3)), viewpoint)
    except ValueError as error:
        raise MeasurementError(f'no deposit delineated: {error}') from error
    flat = [plane.coordinates(contour) for contour in contours]
    containing = containing_contour(plane.coordinates(points), flat)
    sides = side_points(points, tangents(points), contours, containing, plane.normal)

    status = np.where(containing < 0, Status.GAP, Status.MEASURED).astype(np.uint8)
    one_sided = np.isnan(sides.left + sides.right).any(axis=1)
    status[(status == Status.MEASURED) & one_sided] = Status.LOW_CONFIDENCE
    blind = unseen(capture, plane, points, T_base_camera, config.visibility)
    status = np.where(blind == Status.MEASURED, status, blind)
    distance = np.linalg.norm(points - viewpoint, axis=1)
    return sides, status, pixel_edge_sigma(distance, capture.camera.focal_length)


def contours_3d(capture: Capture, T_base_camera: Array, config: ThicknessConfig) -> list[Array]:
    """The fused contours (N_i, 3) in the base frame [m]; vertices without a point are left out."""
    contours = []
    for contour in delineate(capture.image, config.segmentation).fused:
        points = sample_cloud(capture.cloud, contour.astype(np.float64))
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) >= 3:
            contours.append(transform(T_base_camera, points))
    return contours


def unseen(capture: Capture, surface: Plane, points: Array, T_base_camera: Array,
           config: VisibilityConfig) -> StatusArray:
    """What keeps the surface below path points (N, 3) from being judged, as Status (N,).

    MEASURED = nothing; NO_DATA = outside the image or no depth around; OCCLUDED = the cloud
    has something there that stands above the surface.
    """
    T_camera_base = invert(T_base_camera)
    uv = capture.camera.pixels(transform(T_camera_base, surface.project(points)))
    status = np.full(len(points), Status.NO_DATA, np.uint8)
    inside = np.flatnonzero(np.isfinite(uv).all(axis=1) & capture.camera.contains(uv))
    height, width = capture.cloud.shape[:2]
    reach = np.arange(-config.depth_radius, config.depth_radius + 1)
    column, row = np.rint(uv[inside]).astype(np.intp).T
    columns = np.clip(column[:, None, None] + reach, 0, width - 1)
    rows = np.clip(row[:, None, None] + reach[:, None], 0, height - 1)
    around = capture.cloud[rows, columns].reshape(len(inside), -1, 3)
    # The plane in camera coordinates, so that only the few points looked at are computed.
    above = (around @ (T_camera_base[:3, :3] @ surface.normal)
             + surface.height(T_base_camera[:3, 3]))
    known = np.isfinite(above)
    obstructed = (np.where(known, above, -np.inf) > config.occlusion_height).any(axis=1)
    status[inside[known.any(axis=1)]] = Status.MEASURED
    status[inside[obstructed]] = Status.OCCLUDED
    return status


def pixel_edge_sigma(distance: Array, focal_length: float) -> Array:
    """1-sigma uncertainty of a width between two edges known to a whole pixel only [m].

    Each edge is spread evenly over one pixel, whose side is distance / focal_length.
    """
    return distance / focal_length * np.sqrt(2 / 12)
