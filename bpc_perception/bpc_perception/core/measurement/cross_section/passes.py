"""Which of the surface around a path belongs to which of its passes, and where bed begins."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.measurement.cross_section.sections import Sections

CELLS = 2  # of a map of the path, from one sample to the next
MAP_SIZE = 1000  # of the map, at most [cells]


@dataclass(frozen=True)
class Territory:
    """What the path alone says of the samples of N sections.

    Attributes:
        beside: (N, M) whether one lies so far from all of the path that bed is to be expected.
        clearance: (2, N) how far that is from the path, on the right and the left [m].
        foreign: (N, M) whether another pass of the path is nearer than this one.
    """

    beside: Flags
    clearance: Array
    foreign: Flags


def find_territory(points: Array, index: Index, lateral: Array, offset: Array,
                   spacing: float) -> Territory:
    """Of sections across a path (P, 2) in the plane of the bed, along unit vectors (N, 2).

    They lie at path points of an ``index`` (N,), their samples at an ``offset`` (M,) from these.
    Path points are ``spacing`` apart [m].
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
    foreign: Flags = (along > np.pi * np.abs(offset) + 4 * spacing) & (
        distance < np.abs(offset) - spacing)
    beside = np.zeros(distance.shape, bool)
    clearance = []
    for side in (offset < 0, offset > 0):
        clearance.append(distance[:, side].max(axis=1).astype(np.float64))
        # Close to other strands only half-way to them; in the open more of the bed, lest
        # something that lies there be taken for it.
        openness = clearance[-1] / reach
        nearest_bed = clearance[-1] * (0.85 - 0.35 * openness**2)
        beside[:, side] = distance[:, side] >= nearest_bed[:, None]
    return Territory(beside, np.stack(clearance), foreign)


def find_nearest(points: Array, start: Array, lateral: Array,
                 offset: Array) -> tuple[Index, Floats]:
    """Index (N, M) of which of points (P, 2) is nearest to each sample, and its distance [m].

    Samples are at an ``offset`` (M,) from starts (N, 2) along unit vectors (N, 2).

    By a distance transform of a map of the path [Borgefors 1986], a tenth of the time of a tree.
    """
    reach = np.abs(offset).max()
    low = points.min(axis=0) - reach
    extent = points.max(axis=0) + reach - low
    cell = max((offset[1] - offset[0]) / CELLS, float(extent.max()) / MAP_SIZE)
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


def meets_itself(sections: Sections, typical: Array, inked: Flags) -> Flags:
    """Where (N,) ink of another pass of the path lies on the cross segment of this one.

    ``typical`` (N,) are the widths to be expected [m].
    """
    met = np.zeros(len(typical), bool)
    index = np.flatnonzero(inked & np.isfinite(typical))
    if len(index) == 0:
        return met
    half, foot, margin = typical / 2, sections.foot, sections.pixel
    pairs = cKDTree(foot[index]).query_pairs(
        2 * float(half[index].max()) + margin, output_type='ndarray')
    pairs = index[pairs]
    # Most are neighbours on one pass.
    apart = np.abs(np.diff(sections.index[pairs], axis=1)[:, 0]) * sections.spacing
    pairs = pairs[apart > half[pairs].sum(axis=1)]
    for one, other in (pairs.T, pairs[:, ::-1].T):
        away = foot[other] - foot[one]
        across = np.abs(np.einsum('nk,nk->n', away, sections.lateral[one]))
        distance = np.linalg.norm(away, axis=1)
        along = np.sqrt(np.maximum(distance**2 - across**2, 0.0))
        reached = np.hypot(np.maximum(across - half[one] - margin, 0.0), along) < half[other]
        # A bend of one pass is no longer than half a circle on its chord, and some.
        arc = np.abs(sections.index[one] - sections.index[other]) * sections.spacing
        met[one[reached & (arc > np.pi / 2 * distance + half[one] + half[other])]] = True
    return met
