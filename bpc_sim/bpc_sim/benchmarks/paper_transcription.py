"""The paper's method as its text says it, with a loop for every "for each".

For the benchmark only.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import SegmentationConfig
from bpc_perception.core.geometry import transform
from bpc_perception.core.path.deposition_path import DepositionPath

Contour = NDArray[np.int32]
Point = tuple[float, float, float]


def measure_as_in_the_paper(capture: Capture, path: DepositionPath, T_base_camera: Array) -> Array:
    """Return the thickness (N,) [m] along a path; 0 where no contour contains the point."""
    contours = [[tuple(point) for point in transform(
        T_base_camera, capture.cloud[contour[:, 1], contour[:, 0]].astype(float)).tolist()]
        for contour in delineate(capture.image) if len(contour) >= 3]
    outlines = [np.array([point[:2] for point in contour], np.float32) for contour in contours]
    points = [tuple(point) for point in path.points.tolist()]
    thickness = np.zeros(len(points))
    for i, point in enumerate(points):
        holding = [contour for contour, outline in zip(contours, outlines, strict=True)
                   if cv2.pointPolygonTest(outline, point[:2], False) >= 0]
        if holding:
            before, after = points[max(i - 1, 0)], points[min(i + 1, len(points) - 1)]
            thickness[i] = width_at(point, before, after, holding[0])
    return thickness


def width_at(point: Point, before: Point, after: Point, contour: list[Point]) -> float:
    """Return the width [m] between the nearest points of a contour to the left and the right.

    The points lie in the plane across the path. NaN where one side has none.
    """
    px, py, pz = point
    tx, ty, tz = (b - a for a, b in zip(before, after, strict=True))
    left, right = None, None
    nearest_left, nearest_right = math.inf, math.inf
    for k in range(len(contour)):
        ax, ay, az = contour[k]
        bx, by, bz = contour[(k + 1) % len(contour)]
        from_a = (ax - px) * tx + (ay - py) * ty + (az - pz) * tz
        from_b = (bx - px) * tx + (by - py) * ty + (bz - pz) * tz
        if (from_a > 0) == (from_b > 0):
            continue
        share = from_a / (from_a - from_b)
        q = (ax + share * (bx - ax), ay + share * (by - ay), az + share * (bz - az))
        distance = math.dist(q, point)
        # To the left of the path, as the bed's normal is z.
        if (q[1] - py) * tx - (q[0] - px) * ty > 0:
            if distance < nearest_left:
                nearest_left, left = distance, q
        elif distance < nearest_right:
            nearest_right, right = distance, q
    return math.dist(left, right) if left and right else math.nan


def delineate(image: NDArray[np.uint8]) -> list[Contour]:
    """Return fused contours (M, 2): raw ones in the order of the rough ones around them."""
    config = SegmentationConfig()
    edges = cv2.Canny(image, config.canny_low, config.canny_high)
    raw = find_contours(edges)
    filled = np.zeros(image.shape[:2], np.uint8)
    for contour in raw:
        cv2.drawContours(filled, [contour], 0, 255, cv2.FILLED)
    dilated = cv2.dilate(filled, np.ones((config.kernel_size, config.kernel_size), np.uint8))
    fused = []
    for rough in find_contours(cv2.bitwise_or(
            cv2.Canny(dilated, config.canny_low, config.canny_high), dilated), cv2.RETR_EXTERNAL):
        own = []
        for contour in raw:
            votes = sum(cv2.pointPolygonTest(rough, (float(u), float(v)), False) >= 0
                        for u, v in contour)
            if 2 * votes > len(contour):
                own.append(contour)
        if own:
            fused.append(fuse(rough, own, config.jump_threshold))
    return fused


def fuse(rough: Contour, raw: list[Contour], jump_threshold: int) -> Contour:
    """Return the nearest raw vertex to each rough one, with the raw vertices between them."""
    vertices = np.concatenate(raw)
    owner = np.repeat(np.arange(len(raw)), [len(contour) for contour in raw])
    anchors = [int(np.argmin(((vertices - point)**2).sum(axis=1))) for point in rough]
    order: list[int] = []
    for k, anchor in enumerate(anchors):
        following = anchors[(k + 1) % len(anchors)]
        jump = following - anchor
        if owner[anchor] == owner[following] and 0 < abs(jump) < jump_threshold:
            order.extend(range(anchor, following, 1 if jump > 0 else -1))
        else:
            order.append(anchor)
    return vertices[order]


def find_contours(edges: cv2.typing.MatLike, mode: int = cv2.RETR_LIST) -> list[Contour]:
    """Return contours (M, 2) as traced, with every vertex."""
    contours, _ = cv2.findContours(edges, mode, cv2.CHAIN_APPROX_NONE)
    return [np.asarray(contour[:, 0], np.int32) for contour in contours]
