"""The surface that is printed on, and what stands in front of it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.capture import Capture
from bpc_perception.core.config import VisibilityConfig
from bpc_perception.core.geometry import Array, invert, Plane, transform
from bpc_perception.core.profile import Status

Mask = NDArray[np.uint8]
StatusArray = NDArray[np.uint8]

# Around each path pixel depth is looked up on a grid this wide, to see the bed on either side.
REACH = 24  # [pixels]
PROBES = 300  # path points at which the bed is probed
TRIALS = 100
INLIER = 0.002  # a bead's height, and the bend of a slightly curved bed [m]
SEED = 0


def bed_plane(capture: Capture, points: Array, T_base_camera: Array) -> Plane:
    """The plane of the bed around path points (N, 3), in the base frame [m].

    The plane that holds most of the cloud around the path [Fischler and Bolles 1981], so that a
    nozzle or a hand in front of part of it does no harm. Its normal points to the camera.

    Raises ValueError where the camera has too few points around the path.
    """
    every = points[::max(1, len(points) // PROBES)]
    uv = capture.camera.pixels(transform(invert(T_base_camera), every))
    uv = uv[np.isfinite(uv).all(axis=1) & capture.camera.contains(uv)]
    steps = np.linspace(-REACH, REACH, 5)
    grid = uv[:, None, None] + np.stack(np.meshgrid(steps, steps), axis=-1)
    u, v = np.rint(grid).astype(np.intp).reshape(-1, 2).T
    inside = (u >= 0) & (u < capture.camera.width) & (v >= 0) & (v < capture.camera.height)
    cloud = capture.cloud[v[inside], u[inside]].astype(np.float64)
    cloud = transform(T_base_camera, cloud[np.isfinite(cloud).all(axis=1)])
    if len(cloud) < 3:
        raise ValueError(f'cloud: expected points around the path, found {len(cloud)} where '
                         f'{len(uv)} of {len(every)} path points are in the image')
    corners = cloud[np.random.default_rng(SEED).integers(0, len(cloud), (TRIALS, 3))]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    spanning = lengths > 1e-9
    if not spanning.any():
        raise ValueError('cloud: expected points that span a plane around the path, found none')
    normals = normals[spanning] / lengths[spanning, None]
    distances = np.abs(cloud @ normals.T - np.einsum('ij,ij->i', corners[spanning, 0], normals))
    best = np.argmax((distances < INLIER).sum(axis=0))
    near = cloud[distances[:, best] < INLIER]
    centre = near.mean(axis=0)
    normal = np.linalg.svd(near - centre, full_matrices=False)[2][2]
    if normal @ (T_base_camera[:3, 3] - centre) < 0:
        normal = -normal
    return Plane(normal, float(-normal @ centre))


def obstacles(capture: Capture, bed: Plane, T_base_camera: Array, height: float) -> Mask:
    """Where (H, W) something stands more than ``height`` [m] above the bed, as 255."""
    # The plane in the camera frame, so that the cloud need not be transformed.
    normal = (T_base_camera[:3, :3].T @ bed.normal).astype(np.float32)
    above = capture.cloud @ normal + np.float32(bed.height(T_base_camera[:3, 3]))
    return (above > height).astype(np.uint8) * 255  # NaN is not above


def visibility(capture: Capture, bed: Plane, obstacle: Mask, points: Array,
               T_base_camera: Array, config: VisibilityConfig) -> StatusArray:
    """What keeps the bed below path points (N, 3) from being judged, as Status (N,).

    MEASURED = nothing; NO_DATA = outside the image or no depth around; OCCLUDED = something
    stands in front.
    """
    uv = capture.camera.pixels(transform(invert(T_base_camera), bed.project(points)))
    inside = np.flatnonzero(np.isfinite(uv).all(axis=1) & capture.camera.contains(uv))
    u, v = np.rint(uv[inside]).astype(np.intp).T
    status = np.full(len(points), Status.NO_DATA, np.uint8)
    side = 2 * config.depth_radius + 1
    kernel = np.ones((side, side), np.uint8)
    known = cv2.dilate(np.isfinite(capture.cloud[..., 2]).astype(np.uint8), kernel)
    status[inside[known[v, u] > 0]] = Status.MEASURED
    status[inside[near(obstacle, config.margin)[v, u] > 0]] = Status.OCCLUDED
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
