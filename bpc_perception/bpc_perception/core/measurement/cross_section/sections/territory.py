"""Which of the surface around a path belongs to which of its passes, and where bed begins."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats, Index

CELLS_PER_SAMPLE = 2  # of the map of the path
LARGEST_MAP_CELLS = 1000  # along its longer side
# From which share of the clearance bed is expected: close to other strands only half-way to them,
# in the open farther out, where nothing that lies beside the bead is taken for bed.
CLOSE_BED, OPEN_BED_GAIN = 0.85, 0.35
NEIGHBOURS = 4  # path points that are near to a place on their own pass


@dataclass(frozen=True)
class Territory:
    """What the path alone says of N sections with M samples each.

    Attributes:
        beside: (N, M) whether a sample lies so far from all of the path that bed is expected.
        clearance: (2, N) the farthest that a sample lies from all of the path, on the right and
            on the left [m].
        foreign: (N, M) whether another pass of the path is nearer than the section's own.
    """

    beside: Flags
    clearance: Array
    foreign: Flags


def find_territory(points: Array, index: Index, lateral: Array, offset: Array,
                   spacing: float) -> Territory:
    """Find what belongs to which pass, in the plane of the bed.

    Args:
        points: (P, 2) the path [m].
        index: (N,) of the path points at which the sections lie.
        lateral: (N, 2) unit vectors along the sections, to the left.
        offset: (M,) of the samples from the path points, positive to the left [m].
        spacing: between path points [m].
    """
    # What is farther away is near to none of the samples.
    around = points[index]
    reach = np.abs(offset).max()
    low, high = around.min(axis=0) - 2 * reach, around.max(axis=0) + 2 * reach
    x, y = points.T
    close = np.flatnonzero((x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1]))
    nearest, distance = find_nearest(points[close], around, lateral, offset)
    along = np.abs(close[nearest] - index[:, None]) * spacing
    distance = np.minimum(distance, np.abs(offset).astype(np.float32))  # its own point is near
    # The foot of a place on its own pass is near in arc length, even within a bend.
    foreign: Flags = (along > np.pi * np.abs(offset) + NEIGHBOURS * spacing) & (
        distance < np.abs(offset) - spacing)
    beside = np.zeros(distance.shape, bool)
    sides = (offset < 0, offset > 0)
    clearance = np.stack([distance[:, side].max(axis=1).astype(np.float64) for side in sides])
    for side, clear in zip(sides, clearance, strict=True):
        openness = clear / reach
        nearest_bed = clear * (CLOSE_BED - OPEN_BED_GAIN * openness**2)
        beside[:, side] = distance[:, side] >= nearest_bed[:, None]
    return Territory(beside, clearance, foreign)


def find_nearest(points: Array, start: Array, lateral: Array,
                 offset: Array) -> tuple[Index, Floats]:
    """Find the nearest path point to each sample of sections, and how far it is.

    A distance transform of a map of the path [Borgefors 1986] takes a tenth of the time of a tree.

    Args:
        points: (P, 2) the path [m].
        start: (N, 2) where the sections meet it [m].
        lateral: (N, 2) unit vectors along the sections.
        offset: (M,) of the samples from the starts [m].

    Returns:
        Index (N, M) of the nearest point, and its distance (N, M) [m].
    """
    reach = np.abs(offset).max()
    low = points.min(axis=0) - reach
    extent = points.max(axis=0) + reach - low
    cell = max((offset[1] - offset[0]) / CELLS_PER_SAMPLE,
               float(extent.max()) / LARGEST_MAP_CELLS)
    x, y = ((points - low) / cell).astype(np.float32).T
    places = [((origin[:, None] + offset * side[:, None]) / cell).astype(np.float32)
              for origin, side in zip((start - low).T, lateral.T, strict=True)]

    free = np.ones(np.ceil(extent[::-1] / cell).astype(int) + 2, np.uint8)
    column, row = np.rint(x).astype(np.intp), np.rint(y).astype(np.intp)
    free[row, column] = 0
    _, label = cv2.distanceTransformWithLabels(free, cv2.DIST_L2, cv2.DIST_MASK_5,
                                               labelType=cv2.DIST_LABEL_PIXEL)
    owner = np.zeros(len(points) + 1, np.intp)
    owner[label[row, column]] = np.arange(len(points))
    nearest = owner[label[np.rint(places[1]).astype(np.intp), np.rint(places[0]).astype(np.intp)]]
    distance = np.hypot(places[0] - x[nearest], places[1] - y[nearest]) * np.float32(cell)
    return nearest, distance
