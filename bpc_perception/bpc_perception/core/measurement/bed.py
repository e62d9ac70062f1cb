"""The surface that is printed on."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.geometry import invert, Plane, transform

# Around each path pixel depth is looked up on a grid this wide, to see the bed on either side.
REACH = 24  # [pixels]
PROBES = 60  # path points at which the bed is probed
TRIALS = 100
REFITS = 3  # on a curved bed the first may lean to one side
JURY = 1000  # points of the cloud that choose between the trials
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
    some = cloud[::max(1, len(cloud) // JURY)]
    corners = cloud[np.random.default_rng(SEED).integers(0, len(cloud), (TRIALS, 3))]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    spanning = lengths > 1e-9
    if not spanning.any():
        raise ValueError('cloud: expected points that span a plane around the path, found none')
    normals = normals[spanning] / lengths[spanning, None]
    offsets = np.einsum('ij,ij->i', corners[spanning, 0], normals)
    best = np.argmax((np.abs(some @ normals.T - offsets) < INLIER).sum(axis=0))
    normal, offset = normals[best], offsets[best]
    for _ in range(REFITS):
        near = cloud[np.abs(cloud @ normal - offset) < INLIER]
        centre = near.mean(axis=0)
        # The direction in which the points spread least.
        normal = np.linalg.eigh((near - centre).T @ (near - centre))[1][:, 0]
        offset = normal @ centre
    if normal @ (T_base_camera[:3, 3] - centre) < 0:
        normal = -normal
    return Plane(normal, float(-normal @ centre))
