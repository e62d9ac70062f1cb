"""Edges as they go on along the path: which of two is right, what is a flaw, and smoothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.filters import running_median
from bpc_perception.core.measurement.cross_section.edges.rim import steepest_shift
from bpc_perception.core.measurement.cross_section.sections.sections import (
    SAMPLE_STEP_PX,
    Sections,
)
from bpc_perception.core.measurement.scale import steady_window

CHOICE_SIGMA_PX = 0.3  # 1-sigma uncertainty where one of two edges had to be chosen
SHIFT_DOUBT = 0.25  # share of the shift to the steepest place that is not sure
SPIKE_PX = 1.0  # an edge farther from its neighbours is a flaw of the image,
SPIKE_SIGMAS = 4.0  # if it is farther than this, too
SPIKE_NEIGHBOURS = 5  # path points, with the edge's own
ISLAND_M = 0.003  # a shorter stretch between two jumps is a flaw, too
SMOOTHING = 1 / 8  # sigma of the smoothing along the path, per width of the bead
MOST_PASSES = 20  # of smoothing


@dataclass(frozen=True)
class Located:
    """Edges on one side of N path points.

    Attributes:
        distance: (N,) from the path [m]; NaN = none.
        sigma: (N,) its 1-sigma uncertainty from noise [m].
    """

    distance: Array
    sigma: Array

    def part(self, chosen: slice) -> Located:
        """Return some of the edges."""
        return Located(self.distance[chosen], self.sigma[chosen])

    def or_else(self, other: Located, where: Flags) -> Located:
        """Return these edges, but those of another where (N,) told so."""
        return Located(np.where(where, other.distance, self.distance),
                       np.where(where, other.sigma, self.sigma))


def follow_along_path(sections: Sections, noise: Array, share: Floats, near: Located,
                      far: Located, sure: Flags) -> tuple[Array, Array]:
    """Follow the edges of one side along the path.

    Args:
        sections: N sections.
        noise: (N,) 1-sigma noise of a share of ink.
        share: (N, K) of ink in the samples outward on this side.
        near: (N,) the nearer edge.
        far: (N,) the farther edge.
        sure: (N,) where both are the same.

    Returns:
        Distances (N,) and their 1-sigma uncertainties (N,) [m]; NaN = no edge.
    """
    step = SAMPLE_STEP_PX * sections.pixel
    chosen = near if sure.all() else choose(sections, near, far, sure)
    tolerance = np.fmax(SPIKE_SIGMAS * chosen.sigma, SPIKE_PX * sections.pixel)
    flaw = flaws(chosen.distance, tolerance, sections.spacing, sections.piece)
    distance, sigma = (np.where(flaw, np.nan, values)
                       for values in (chosen.distance, chosen.sigma))
    shift = steepest_shift(share, distance / step, noise, sections.in_row,
                           steady_window(sections.spacing), sections.spacing / sections.pixel,
                           sections.piece)
    distance = distance + shift * step
    sigma = np.hypot(sigma, np.nan_to_num(SHIFT_DOUBT * shift * step))
    passes = smoothing_passes(distance, sections.spacing)
    smooth = smoothed(distance, passes, sections.piece)
    gain = np.where(smooth == distance, 1.0, (2 * np.pi * max(passes, 1)) ** -0.25)
    return smooth, sigma * gain


def choose(sections: Sections, near: Located, far: Located, sure: Flags) -> Located:
    """Choose the nearer or the farther edge, whichever goes on along the path."""
    expected = sections.steady(np.where(sure, near.distance, np.nan))
    mostly_sure = sections.steady(sure.astype(float)) > 0.5
    if not mostly_sure.all():
        expected = np.where(mostly_sure, expected, sections.steady(far.distance))
    off = np.abs(near.distance - expected)
    # Where glare on the bed hides how it goes on, there may be no farther edge.
    alone = np.isnan(far.distance) & (off <= SPIKE_PX * sections.pixel)
    take_far = ~sure & ~alone & ~(off <= np.abs(far.distance - expected))
    chosen = near.or_else(far, take_far)
    doubt = np.where(sure, 0.0, CHOICE_SIGMA_PX * sections.pixel)
    return Located(chosen.distance, np.hypot(chosen.sigma, doubt))


def flaws(distance: Array, tolerance: Array, spacing: float, piece: Index) -> Flags:
    """Return where (N,) an edge does not go on from its neighbours.

    These are single edges, and short stretches that begin and end with a jump, as where a
    reflection runs along the side of a bead.

    Args:
        distance: (N,) of the edge from the path [m]; NaN = none.
        tolerance: (N,) within which an edge goes on [m].
        spacing: between path points [m].
        piece: (N,) number of the piece of path; between pieces nothing goes on.
    """
    single = np.abs(distance - running_median(distance, SPIKE_NEIGHBOURS, piece)) > tolerance
    other = piece[1:] != piece[:-1]
    jump = (np.abs(np.diff(distance)) > np.maximum(tolerance[1:], spacing)) & ~other
    unknown = np.isnan(distance)
    border = np.concatenate(([True], jump | other | unknown[1:] | unknown[:-1]))
    stretch = np.cumsum(border) - 1
    length = np.bincount(stretch)[stretch] * spacing
    jumps = np.bincount(stretch, np.concatenate(([False], jump)), len(border))
    # A stretch begins with its own jump, and ends with that of the next.
    ends = np.append(jumps[1:], 0.0)
    return single | ((length < ISLAND_M) & (jumps > 0)[stretch] & (ends > 0)[stretch])


def smoothed(values: Array, passes: int, piece: Index) -> Array:
    """Return values (N,) with a quarter of each neighbour mixed in, ``passes`` times.

    Near unknown values, NaN, and near the ends of pieces (N,) it is done fewer times.
    """
    result = values.copy()
    inner = np.isfinite(values)
    other = piece[1:] != piece[:-1]
    ends = np.append(True, other) | np.append(other, True)
    for _ in range(passes):
        inner[1:-1] &= inner[:-2] & inner[2:]
        inner[ends] = False
        middle = (result[:-2] + 2 * result[1:-1] + result[2:]) / 4
        result[1:-1][inner[1:-1]] = middle[inner[1:-1]]
    return result


def smoothing_passes(distance: Array, spacing: float) -> int:
    """Return how many times edges (N,) [m] of a bead are smoothed; each adds 1/2 to the variance.

    Surface tension levels what is shorter than a bead is wide (Plateau and Rayleigh). Smoothing
    takes a quarter of what is as long, and a fourteenth of what is twice as long.
    """
    known = distance[np.isfinite(distance)]
    if len(known) == 0:
        return 0
    sigma = SMOOTHING * 2 * float(np.median(known)) / spacing
    return min(round(2 * sigma**2), MOST_PASSES)
