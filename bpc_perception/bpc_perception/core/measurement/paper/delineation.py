"""Delineation of the deposit in the image: Sec. III-A of Zobeidi et al., IROS 2026.

Raw contours lie exactly on the edges but do not close; rough contours close but are dilated;
their fusion does both. A contour is an (N, 2) integer array of pixels (u, v), closed from its
last vertex to its first.
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
    """The contours of each step, for looking at; ``fused`` is the result."""

    raw: list[Contour]
    rough: list[Contour]
    fused: list[Contour]


def delineate(image: Image, config: SegmentationConfig) -> Delineation:
    """One closed contour around each region of deposit in an RGB image (H, W, 3)."""
    raw = raw_contours(image, config)
    rough = rough_contours(raw, image.shape[:2], config)
    fused = [fuse(outline, candidates, config.jump_threshold)
             for outline, candidates in zip(rough, corresponding(raw, rough, image.shape[:2]),
                                            strict=True) if candidates]
    return Delineation(raw, rough, [contour for contour in fused if len(contour) >= 3])


def raw_contours(image: Image, config: SegmentationConfig) -> list[Contour]:
    """Contours of the Canny edges (Sec. III-A.1), in tracing order [Suzuki and Abe 1985]."""
    edges = cv2.Canny(image, config.canny_low, config.canny_high)
    return _find_contours(edges, cv2.RETR_LIST)


def rough_contours(raw: list[Contour], shape: tuple[int, ...],
                   config: SegmentationConfig) -> list[Contour]:
    """Contours around the filled and dilated raw contours (Sec. III-A.2), one a region."""
    # A frame of background keeps regions that touch the image's border closed.
    margin = config.kernel_size
    filled = np.zeros((shape[0] + 2 * margin, shape[1] + 2 * margin), np.uint8)
    for contour in raw:  # one call for all would fill by parity and open what they overlap
        cv2.drawContours(filled, [contour], 0, 255, cv2.FILLED, offset=(margin, margin))
    kernel = np.ones((config.kernel_size, config.kernel_size), np.uint8)
    dilated = cv2.dilate(filled, kernel)
    edges = cv2.Canny(dilated, config.canny_low, config.canny_high)
    # Canny breaks at sharp corners, even of a binary image; with the region it stays closed.
    return [contour - margin
            for contour in _find_contours(cv2.bitwise_or(edges, dilated), cv2.RETR_EXTERNAL)]


def corresponding(raw: list[Contour], rough: list[Contour],
                  shape: tuple[int, ...]) -> list[list[Contour]]:
    """For each rough contour the raw ones with over half of their vertices inside (Eq. 1)."""
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
    # Rough regions do not overlap, so at most one holds over half of a contour's vertices.
    for chosen in np.flatnonzero((number > 0) & (votes * 2 > lengths[index])):
        assigned[number[chosen] - 1].append(raw[index[chosen]])
    return assigned


def fuse(rough: Contour, raw: list[Contour], jump_threshold: int) -> Contour:
    """Stitch pieces of raw contours together in the order of a rough one (Sec. III-A.3).

    Each rough vertex is replaced by its nearest raw vertex, its anchor (Eq. 2). Between
    consecutive anchors on one raw contour less than ``jump_threshold`` vertices apart, the raw
    vertices in between are inserted, forwards or backwards; otherwise anchors are joined by a
    straight line.
    """
    lengths = np.array([len(contour) for contour in raw])
    vertices = np.concatenate(raw)
    owner = np.repeat(np.arange(len(raw)), lengths)
    _, anchor = cKDTree(vertices).query(rough)
    following = np.roll(anchor, -1)
    step = following - anchor
    stitched = (owner[anchor] == owner[following]) & (np.abs(step) < jump_threshold)
    # Each anchor contributes itself and, when stitched, the vertices up to the next anchor;
    # indices within one raw contour are consecutive in `vertices` as well.
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
