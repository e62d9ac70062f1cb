"""Delineation of the deposit in the image: Sec. III-A of Zobeidi et al., IROS 2026.

Raw contours lie exactly on the edges but do not close. Rough contours close but are dilated.
Fused contours lie on the edges and close. A contour is an (N, 2) integer array of pixels (u, v),
closed from its last vertex to its first.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from bpc_perception.core.config import SegmentationConfig

Contour = NDArray[np.int32]
Image = NDArray[np.uint8]


@dataclass(frozen=True)
class Delineation:
    """The contours of each step; ``fused`` is the result, the others are for looking at."""

    raw: list[Contour]
    rough: list[Contour]
    fused: list[Contour]


def delineate(image: Image, config: SegmentationConfig) -> Delineation:
    """Return closed contours, one around each region of deposit in an RGB image (H, W, 3)."""
    raw = raw_contours(image, config)
    rough = rough_contours(raw, image.shape[:2], config)
    fused = [fuse(outline, candidates, config.jump_threshold)
             for outline, candidates in zip(rough, corresponding(raw, rough, image.shape[:2]),
                                            strict=True) if candidates]
    return Delineation(raw, rough, [contour for contour in fused if len(contour) >= 3])


def raw_contours(image: Image, config: SegmentationConfig) -> list[Contour]:
    """Return the contours of the Canny edges in an RGB image (H, W, 3) (Sec. III-A.1).

    They are in tracing order [Suzuki and Abe 1985].
    """
    edges = cv2.Canny(image, config.canny_low, config.canny_high)
    return _find_contours(edges, cv2.RETR_LIST)


def rough_contours(raw: list[Contour], shape: tuple[int, ...],
                   config: SegmentationConfig) -> list[Contour]:
    """Return contours around the filled and dilated raw contours, one a region (Sec. III-A.2).

    The shape is that of the image, (H, W).
    """
    # A frame of background keeps regions that touch the image's border closed.
    margin = config.kernel_size
    filled = np.zeros((shape[0] + 2 * margin, shape[1] + 2 * margin), np.uint8)
    for contour in raw:  # one call for all would fill by parity, and leave overlaps open
        cv2.drawContours(filled, [contour], 0, 255, cv2.FILLED, offset=(margin, margin))
    kernel = np.ones((config.kernel_size, config.kernel_size), np.uint8)
    dilated = cv2.dilate(filled, kernel)
    edges = cv2.Canny(dilated, config.canny_low, config.canny_high)
    # Canny breaks at sharp corners, even in a binary image; with the region added it is closed.
    return [contour - margin
            for contour in _find_contours(cv2.bitwise_or(edges, dilated), cv2.RETR_EXTERNAL)]


def corresponding(raw: list[Contour], rough: list[Contour],
                  shape: tuple[int, ...]) -> list[list[Contour]]:
    """Return for each rough contour the raw contours that belong to it (Eq. 1).

    Those have more than half of their vertices inside. The shape is that of the image, (H, W).
    """
    if not raw:
        return [[] for _ in rough]
    region = np.zeros(shape[:2], np.int32)
    for label, contour in enumerate(rough, start=1):
        cv2.drawContours(region, [contour], 0, label, cv2.FILLED)
    lengths = np.array([len(contour) for contour in raw])
    owner = np.repeat(np.arange(len(raw)), lengths)
    u, v = np.concatenate(raw).T
    pair, votes = np.unique(owner * (len(rough) + 1) + region[v, u], return_counts=True)
    index, number = np.divmod(pair, len(rough) + 1)
    assigned: list[list[Contour]] = [[] for _ in rough]
    # Rough regions do not overlap, so at most one has over half of a contour's vertices.
    for chosen in np.flatnonzero((number > 0) & (votes * 2 > lengths[index])):
        assigned[number[chosen] - 1].append(raw[index[chosen]])
    return assigned


def fuse(rough: Contour, raw: list[Contour], jump_threshold: int) -> Contour:
    """Stitch pieces of raw contours together in the order of a rough contour (Sec. III-A.3).

    Each rough vertex is replaced by its nearest raw vertex, its anchor (Eq. 2). If two consecutive
    anchors are on one raw contour, less than ``jump_threshold`` vertices apart, the raw vertices
    between them are inserted, forwards or backwards. Otherwise a straight line joins them.
    """
    lengths = np.array([len(contour) for contour in raw])
    vertices = np.concatenate(raw)
    owner = np.repeat(np.arange(len(raw)), lengths)
    _, anchor = cKDTree(vertices).query(rough)
    following = np.roll(anchor, -1)
    step = following - anchor
    stitched = (owner[anchor] == owner[following]) & (np.abs(step) < jump_threshold)
    # Each anchor contributes itself and, if stitched, the vertices up to the next anchor. Indices
    # within one raw contour are consecutive in `vertices` as well.
    count = np.where(stitched, np.maximum(np.abs(step), 1), 1)
    first = np.cumsum(count) - count
    within = np.arange(count.sum()) - np.repeat(first, count)
    index = np.repeat(anchor, count) + np.repeat(np.sign(step), count) * within
    contour = vertices[index]
    repeated = (contour == np.roll(contour, 1, axis=0)).all(axis=1)
    return contour[~repeated]


def _find_contours(edges: cv2.typing.MatLike, mode: int) -> list[Contour]:
    contours, _ = cv2.findContours(edges, mode, cv2.CHAIN_APPROX_NONE)
    return [np.asarray(contour[:, 0], np.int32) for contour in contours]
