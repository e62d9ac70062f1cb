"""Which of the surface around a path belongs to which of its passes, and where bed begins."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats, Index

CELLS_PER_SAMPLE = 2  # of the map of the path
LARGEST_MAP_CELLS = 1000  # along its longer side
# From which share of the clearance bed is expected: close to other strands only half-way to them,
# in the open farther out, where nothing that lies beside the bead is taken for bed.
CLOSE_BED, OPEN_BED_GAIN = 0.85, 0.35
NEIGHBOURS = 4  # path points that are near to a place on their own pass
# Of the way outward, by which a section comes nearer to another pass, that crosses the own one at
# less than 53 degrees: where they cross more squarely, the section runs beside it.
LEAST_NEARING = 0.6


@dataclass(frozen=True)
class Territory:
    """What the path alone says of N sections with M samples each.

    Attributes:
        offset: (M,) of the samples from the path, positive to the left, evenly spaced [m].
        distance: (N, M) of each from all of the path [m].
        bed_from: (2, N) distance from which bed is expected, on the right and on the left [m].
        clearance: (2, N) the farthest that a section leads from all of the path, on the right and
            on the left [m].
        foreign: (N, M) whether another pass of the same layer is nearer than the section's own.
        nearing: (N, M) whether the section comes nearer to that outward.
    """

    offset: Array
    distance: Floats
    bed_from: Array
    clearance: Array
    foreign: Flags
    nearing: Flags

    @cached_property
    def beside(self) -> Flags:
        """Whether (N, M) a sample lies so far from all of the path that bed is expected."""
        return self._expects_bed(self.distance, self.offset)

    def beside_at(self, offset: Array) -> Flags:
        """Return the same at other offsets (K,), evenly spaced [m]."""
        place = self._place(offset)
        low = np.clip(place.astype(np.intp), 0, len(self.offset) - 2)
        share = (place - low).astype(np.float32)
        distance = (1 - share) * self.distance[:, low] + share * self.distance[:, low + 1]
        return self._expects_bed(distance, offset)

    def passes_at(self, offset: Array) -> tuple[Flags, Flags]:
        """Return ``foreign`` and ``nearing`` (N, K) at offsets (K,), evenly spaced [m]."""
        near = np.clip(np.rint(self._place(offset)), 0, len(self.offset) - 1).astype(np.intp)
        return self.foreign[:, near], self.nearing[:, near]

    def _place(self, offset: Array) -> Array:
        return (offset - self.offset[0]) / (self.offset[1] - self.offset[0])

    def _expects_bed(self, distance: Floats, offset: Array) -> Flags:
        flags = np.zeros(distance.shape, bool)
        end, start = (np.searchsorted(offset, 0.0, side) for side in ('left', 'right'))
        for side, bed_from in zip((slice(end), slice(start, None)), self.bed_from, strict=True):
            flags[:, side] = distance[:, side] >= bed_from[:, None]
        return flags


def find_territory(points: Array, along: Array, layer: Index, index: Index, lateral: Array,
                   offset: Array, spacing: float) -> Territory:
    """Find what belongs to which pass, in the plane of the bed.

    Args:
        points: (P, 2) the path [m].
        along: (P,) length along the ink, see Track [m].
        layer: (P,) of each.
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
    nearing = leads_nearer(distance, offset)
    apart = np.abs(along[close[nearest]] - along[index][:, None])
    distance = np.minimum(distance, np.abs(offset).astype(np.float32))  # its own point is near
    # The foot of a place on its own pass is near in arc length, even within a bend.
    foreign: Flags = (apart > np.pi * np.abs(offset) + NEIGHBOURS * spacing) & (
        distance < np.abs(offset) - spacing) & (
        layer[close[nearest]] == layer[index][:, None])
    sides = (offset < 0, offset > 0)
    # Half-way to another pass lies between two samples: there the distances from both meet.
    step = offset[1] - offset[0]
    clearance = np.stack([
        ((distance[:, side][:, 1:] + distance[:, side][:, :-1] + step) / 2).max(axis=1)
        for side in sides]).astype(np.float64)
    bed_from = clearance * (CLOSE_BED - OPEN_BED_GAIN * (clearance / reach)**2)
    return Territory(offset, distance, bed_from, clearance, foreign, foreign & nearing)


def leads_nearer(distance: Floats, offset: Array) -> Flags:
    """Return where (N, M) sections lead nearer to a path outward.

    Not where they run beside it, as beside a crossing.

    Args:
        distance: (N, M) from the path [m].
        offset: (M,) of the samples, evenly spaced [m].
    """
    outward = np.sign(offset[1:] + offset[:-1])
    falls = np.diff(distance, axis=1) * outward < -LEAST_NEARING * (offset[1] - offset[0])
    nearing = np.zeros(distance.shape, bool)
    nearing[:, :-1] |= falls
    nearing[:, 1:] |= falls
    return nearing


def find_nearest(points: Array, start: Array, lateral: Array,
                 offset: Array) -> tuple[Index, Floats]:
    """Find the nearest path point to each sample of sections, and how far it is.

    A distance transform of a map of the path [Borgefors 1986] takes a tenth of the time of a tree.

    Args:
        points: (P, 2) the path [m].
        start: (N, 2) where the sections meet it [m].
        lateral: (N, 2) unit vectors along the sections; NaN = no direction is known.
        offset: (M,) of the samples from the starts [m].

    Returns:
        Index (N, M) of the nearest point, and its distance (N, M) [m].
    """
    reach = np.abs(offset).max()
    low = np.minimum(points.min(axis=0), start.min(axis=0)) - reach
    extent = np.maximum(points.max(axis=0), start.max(axis=0)) + reach - low
    cell = max((offset[1] - offset[0]) / CELLS_PER_SAMPLE,
               float(extent.max()) / LARGEST_MAP_CELLS)
    x, y = ((points - low) / cell).astype(np.float32).T
    places = [((origin[:, None] + offset * side[:, None]) / cell).astype(np.float32)
              for origin, side in zip((start - low).T, np.nan_to_num(lateral).T, strict=True)]

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
