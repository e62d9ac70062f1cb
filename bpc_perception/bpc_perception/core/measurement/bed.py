"""The bed: the surface that is printed on."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import AROUND_PX, pixels_around
from bpc_perception.core.geometry import Plane, transform
from bpc_perception.core.measurement.view import View

PROBES = 60  # path points at which the bed is probed
TRIALS = 100
REFITS = 3  # on a curved bed the first may lean to one side
JURY = 1000  # points of the cloud that choose between the trials
INLIER_M = 0.002  # a bead's height, and the bend of a slightly curved bed
# Of the cloud around a path, what is farthest from it is bed; it is even, but for noise.
BARE_SHARE, BARE_INLIER_M = 0.3, 3e-4
LEAST_AREA_M2 = 1e-9  # of the parallelogram of three points that span a plane
LEAST_BEHIND = 0.05  # of the cloud around a path: what is not in front of it
SEED = 0


def find_bed(view: View, points: Array) -> Plane:
    """Find the plane of the bed around path points (N, 3), in the base frame [m].

    It is the plane that holds most of the cloud around the path [Fischler and Bolles 1981]. So a
    nozzle or a hand in front of a part of it does no harm. Its normal points to the camera.

    Raises ValueError where the camera has too few points around the path.
    """
    cloud = cloud_around(view, points)
    return refitted(cloud, *best_plane(cloud), INLIER_M, view.viewpoint)


def bed_beside(view: View, points: Array, bed: Plane) -> Plane:
    """Find the plane of the bed where path points (N, 3) are far, in the base frame [m].

    The plane of all that is around the path lies higher where much of it is ink.
    """
    cloud = cloud_around(view, points)
    away, _ = cKDTree(bed.coordinates(points)).query(bed.coordinates(cloud))
    bare = cloud[away >= np.quantile(away, 1 - BARE_SHARE)]
    return refitted(bare, bed.normal, float(np.median(bare @ bed.normal)), BARE_INLIER_M,
                    view.viewpoint)


def refitted(cloud: Array, normal: Array, offset: float, inlier: float,
             viewpoint: Array) -> Plane:
    """Return the plane through the points of a cloud (K, 3) that lie near to a plane [m].

    Args:
        cloud: the points.
        normal: (3,) of the plane to begin with.
        offset: of this plane, whose points p have p . normal = offset [m].
        inlier: how near [m].
        viewpoint: (3,) to which the normal points.
    """
    for _ in range(REFITS):
        near = cloud[np.abs(cloud @ normal - offset) < inlier]
        centre = near.mean(axis=0)
        # The direction in which the points spread least.
        normal = np.linalg.eigh((near - centre).T @ (near - centre))[1][:, 0]
        offset = normal @ centre
    if normal @ (viewpoint - centre) < 0:
        normal = -normal
    return Plane(normal, float(-normal @ centre))


def cloud_around(view: View, points: Array) -> Array:
    """Return the points (K, 3) of the cloud around path points (N, 3), in the base frame [m].

    Raises ValueError for fewer than three.
    """
    probes = points[::max(1, len(points) // PROBES)]
    inside = probes[view.inside(probes)]
    uv = view.pixels(inside)
    pixels = pixels_around(uv, view.capture.camera)
    cloud = view.capture.cloud[pixels[::-1]].astype(np.float64)
    known = np.isfinite(cloud).all(axis=1)
    if known.sum() < 3:
        doubt = ('does the camera have depth there' if len(uv) else
                 'does the hand-eye calibration fit to this camera and robot')
        raise ValueError(f'cloud: expected points around the path, found {known.sum()} where '
                         f'{len(uv)} of {len(probes)} path points are in the image; {doubt}?')
    _, nearest = cKDTree(uv).query(np.column_stack(pixels)[known])
    return transform(view.T_base_camera, not_in_front(view, cloud[known], inside[nearest]))


def not_in_front(view: View, cloud: Array, path: Array) -> Array:
    """Return the points of a cloud (K, 3) that are no nearer to the camera than the path.

    What stands in front of much of a small print, as the nozzle and what holds it, is no bed.
    Where hardly anything else is seen, the path may be wrong, and all points count.

    Args:
        view: the capture.
        cloud: points in the camera's frame [m].
        path: (K, 3) the path beside each of them, in the base frame [m].
    """
    # A bed that is seen tilted by 45 degrees comes nearer by as much as it goes aside.
    tolerance = INLIER_M + 2**0.5 * AROUND_PX * view.pixel_size(path)
    behind = cloud[:, 2] > transform(view.T_camera_base, path)[:, 2] - tolerance
    return cloud[behind] if behind.mean() > LEAST_BEHIND else cloud


def best_plane(cloud: Array) -> tuple[Array, float]:
    """Return normal (3,) and offset [m] of the plane that holds most of a cloud (K, 3).

    It goes through three of the points. Raises ValueError where no three of those tried span one.
    """
    some = cloud[::max(1, len(cloud) // JURY)]
    corners = cloud[np.random.default_rng(SEED).integers(0, len(cloud), (TRIALS, 3))]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    spanning = areas > LEAST_AREA_M2
    if not spanning.any():
        raise ValueError('cloud: expected points that span a plane around the path, found none'
                         '; does the camera see the bed there?')
    normals = normals[spanning] / areas[spanning, None]
    offsets = np.einsum('ij,ij->i', corners[spanning, 0], normals)
    best = np.argmax((np.abs(some @ normals.T - offsets) < INLIER_M).sum(axis=0))
    return normals[best], float(offsets[best])
