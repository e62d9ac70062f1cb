"""Thickness along the path: Sec. III-B of Zobeidi et al., IROS 2026, step by step.

Contours and path are points in one frame [m]. Contours are closed from last vertex to first.
"""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.side_points import SidePoints

MAXIMUM_TABLE_ENTRIES = 2_000_000  # of vertices x path points
# Second smallest eigenvalue per largest, up to which points are on a line.
LARGEST_LINE_RATIO = 1e-12


def fit_plane(points: Array, viewpoint: Array) -> Plane:
    """Return the plane through points (N, 3) [m].

    It is the eigenvector of P^T P with the smallest eigenvalue, where P = [x y z 1]. The normal
    points to ``viewpoint`` (3,), the camera's position [m].

    Raises ValueError with fewer than three points, or if they do not span a plane.
    """
    if len(points) < 3:
        raise ValueError(f'plane: expected 3 points or more, found {len(points)}'
                         '; does the camera see the bed there?')
    P = np.column_stack((points, np.ones(len(points))))
    eigenvalues, eigenvectors = np.linalg.eigh(P.T @ P / len(P))
    if eigenvalues[1] <= LARGEST_LINE_RATIO * eigenvalues[-1]:
        raise ValueError('plane: expected points that span a plane, found them on a line'
                         '; does the camera see the bed there?')
    a, b, c, d = eigenvectors[:, 0]
    scale = np.linalg.norm((a, b, c))
    plane = Plane(np.array((a, b, c)) / scale, float(d / scale))
    if plane.height(viewpoint) < 0:
        plane = Plane(-plane.normal, -plane.offset)
    return plane


def containing_contour(points: Array, contours: list[Array]) -> Index:
    """Return the index (N,) of the polygon (M_i, 2) that contains each point (N, 2); -1 = none.

    If several contain it, the first counts. The method is ray casting.
    """
    found = np.full(len(points), -1, np.intp)
    order = np.argsort(points[:, 1], kind='stable')
    x, y = points[order].T
    for number, polygon in enumerate(contours):
        start, end = polygon, np.roll(polygon, -1, axis=0)
        # Only the rays of points at a height between an edge's ends can cross the edge.
        low = np.searchsorted(y, np.minimum(start[:, 1], end[:, 1]), side='left')
        high = np.searchsorted(y, np.maximum(start[:, 1], end[:, 1]), side='left')
        edge, point = _expand(low, high)
        share = (y[point] - start[edge, 1]) / (end[edge, 1] - start[edge, 1])
        crossing = start[edge, 0] + share * (end[edge, 0] - start[edge, 0])
        crossings = np.bincount(point[crossing > x[point]], minlength=len(points))
        inside = order[crossings % 2 == 1]
        found[inside] = np.where(found[inside] < 0, number, found[inside])
    return found


def cut_contours(path: Array, tangent: Array, contours: list[Array], containing: Index,
                normal: Array) -> SidePoints:
    """Return where the cut plane of each path point first meets its contour, on both sides.

    The cut plane passes through the path point and is normal to its tangent. Left is where
    (q - p) . (v x t) > 0, with v the surface normal.

    Args:
        path: (N, 3) points [m].
        tangent: (N, 3) of the path, unit vectors.
        contours: each (M_i, 3) [m].
        containing: (N,) index of the contour that contains each point; -1 = none.
        normal: (3,) of the surface, a unit vector.
    """
    sides = np.full((2, len(path), 3), np.nan)
    distances = np.full((2, len(path)), np.nan)
    for number, contour in enumerate(contours):
        members = np.flatnonzero(containing == number)
        # Blocks bound the memory of the (vertices x path points) table.
        blocks = 1 + len(members) * len(contour) // MAXIMUM_TABLE_ENTRIES
        for block in np.array_split(members, blocks):
            if len(block) == 0:
                continue
            point, q = _intersections(path[block], tangent[block], contour)
            point = block[point]
            offset = q - path[point]
            lateral = np.einsum('ij,ij->i', offset, np.cross(normal, tangent[point]))
            # Write from the farthest to the nearest, so that the nearest remains.
            nearest_last = np.argsort(-np.linalg.norm(offset, axis=1), kind='stable')
            side = np.where(lateral > 0, 0, 1)[nearest_last]
            sides[side, point[nearest_last]] = q[nearest_last]
            distances[side, point[nearest_last]] = np.abs(lateral[nearest_last])
    return SidePoints(*sides, *distances)


def _intersections(points: Array, tangent: Array, contour: Array) -> tuple[Index, Array]:
    """Return where a contour (M, 3) crosses the cut planes: plane (K,) and place (K, 3)."""
    distance = contour @ tangent.T - np.einsum('ij,ij->i', points, tangent)
    ahead = distance > 0
    start, plane = np.nonzero(ahead != np.roll(ahead, -1, axis=0))
    end = (start + 1) % len(contour)
    d0, d1 = distance[start, plane], distance[end, plane]
    share = (d0 / (d0 - d1))[:, None]
    return plane, contour[start] + share * (contour[end] - contour[start])


def _expand(low: Index, high: Index) -> tuple[Index, Index]:
    """Return all pairs (i, j) with low[i] <= j < high[i], as two flat arrays."""
    count = high - low
    owner = np.repeat(np.arange(len(count)), count)
    first = np.repeat(np.cumsum(count) - count, count)
    return owner, np.arange(count.sum()) - first + np.repeat(low, count)
