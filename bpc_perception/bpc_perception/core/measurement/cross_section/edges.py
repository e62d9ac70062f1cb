"""Edges of the ink on either side of a path, to a fraction of a pixel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import trapezoid

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.filters import running_median
from bpc_perception.core.measurement.cross_section.rim import steepest
from bpc_perception.core.measurement.cross_section.sections import Sections, STEP
from bpc_perception.core.measurement.scale import WINDOW

Kind = TypeVar('Kind', np.float32, np.bool_)

SETTLED = 2.0  # a stretch of bed that is shorter is noise [pixels]
GLARE = 7.0  # a shorter one with ink behind it may be glare [pixels]
PLATEAU = (1.5, 3.5)  # from the edge to where its two levels are read [pixels]
PASSES = 3  # of reading levels and moving the edge
SPIKE = 1.0  # an edge so far from those around it is a flaw of the image [pixels]
ISLAND = 0.003  # so is a stretch between two jumps that is shorter [m]
DOUBT = 0.3  # 1-sigma uncertainty where two edges had to be chosen between [pixels]
SHIFT_DOUBT = 0.25  # of that shift is not sure
SMOOTHING = 1 / 8  # its sigma along the path, per width of the bead
MAXIMUM_PASSES = 20


@dataclass(frozen=True)
class Edges:
    """First edges outward from N path points on one side.

    Attributes:
        distance: (N,) from the path [m]; NaN = none found.
        sigma: (N,) its 1-sigma uncertainty from noise [m].
        hidden, outside, joined: (N,) whether an obstacle, the image's border or ink up to
            another pass of the path comes first.
    """

    distance: Array
    sigma: Array
    hidden: Flags
    outside: Flags
    joined: Flags


def find_edges(sections: Sections, noise: Array, ink: Floats) -> tuple[Edges, Edges]:
    """The first edges outward on the right and on the left.

    Behind an edge the bed has to be seen for a while. A stretch too short for that, with ink
    again behind it, may be glare on the bead, or bed before a drop spilled beside it: then the
    nearer or the farther edge is right, whichever goes on along the path.
    """
    middle = len(sections.offset) // 2

    def outward(values: NDArray[Kind]) -> NDArray[Kind]:
        """Both sides (2N, K) of values (N, M), the right one first."""
        return np.concatenate((values[:, middle::-1], values[:, middle:]))

    share = outward(ink)
    foreign = np.maximum.accumulate(outward(sections.foreign), axis=1)
    outside = share < 0.5  # False where it is not seen
    nearer, farther = (_first_run(outside | foreign, round(length / STEP))
                       for length in (SETTLED, GLARE))
    count = share.shape[1]
    border = np.where(foreign[:, -1], np.argmax(foreign, axis=1), count)
    before = np.arange(count) < nearer[:, None]
    hidden: Flags = np.any(outward(sections.hidden) & before, axis=1)
    missing: Flags = np.any(outward(~sections.inside) & before, axis=1)
    joined = (nearer >= border) & (border < count) & ~hidden & ~missing

    step = STEP * sections.pixel
    known = ~(hidden | missing | joined)
    sure = nearer == farther
    both_noise = np.tile(noise, 2)

    def locate(first: Index, asked: Flags) -> Array:
        """Distance and sigma (2, 2N) of the edges at ``first`` (2N,); NaN where not asked."""
        row = np.flatnonzero(asked & known & (first > 0) & (first < np.minimum(border, count)))
        found = np.full((2, len(share)), np.nan)
        position, slope = refine(share[row], first[row], both_noise[row])
        found[:, row] = position * step, both_noise[row] * step / slope
        return found

    near = locate(nearer, np.ones(len(share), bool))
    far = np.where(sure, near, locate(farther, ~sure))
    right, left = (
        Edges(*_follow(sections, noise, share[side], near[:, side], far[:, side], sure[side]),
              hidden[side], missing[side], joined[side])
        for side in (slice(None, len(noise)), slice(len(noise), None)))
    return right, left


def _follow(sections: Sections, noise: Array, share: Floats, near: Array, far: Array,
            sure: Flags) -> tuple[Array, Array]:
    """Distances and sigmas (N,) of one side's edges, as they go on along the path.

    From the distances and sigmas (2, N) of the nearer and the farther edges.
    """
    step = STEP * sections.pixel
    distance, sigma = near
    if not sure.all():
        expected = sections.steady(np.where(sure, near[0], np.nan))
        share_sure = sections.steady(sure.astype(float))
        expected = np.where(share_sure > 0.5, expected, sections.steady(far[0]))
        take_far = ~sure & ~(np.abs(near[0] - expected) <= np.abs(far[0] - expected))
        distance, sigma = np.where(take_far, far, near)
        sigma = np.hypot(sigma, np.where(sure, 0.0, DOUBT * sections.pixel))
    flaw = flaws(distance, np.fmax(4 * sigma, SPIKE * sections.pixel), sections.spacing)
    distance, sigma = (np.where(flaw, np.nan, values) for values in (distance, sigma))
    shift = steepest(share, distance / step, noise,
                     2 * round(WINDOW / 2 / sections.spacing) + 1,
                     sections.spacing / sections.pixel)
    distance = distance + shift * step
    sigma = np.hypot(sigma, np.nan_to_num(SHIFT_DOUBT * shift * step))
    passes = smoothing_passes(distance, sections.spacing)
    smooth = smoothed(distance, passes)
    gain = np.where(smooth == distance, 1.0, (2 * np.pi * max(passes, 1)) ** -0.25)
    return smooth, sigma * gain


def _first_run(flags: Flags, length: int) -> Index:
    """Where (N,) the first run of so many True starts in each row (N, K); K = there is none."""
    # Eroded to where the next so many are all True; beyond the rows they are.
    full = np.ones((len(flags), flags.shape[1] + 1), np.uint8)
    full[:, :-1] = cv2.erode(flags.view(np.uint8), np.ones((1, length), np.uint8), anchor=(0, 0),
                             borderType=cv2.BORDER_CONSTANT, borderValue=1)
    return np.argmax(full, axis=1)


def flaws(distance: Array, tolerance: Array, spacing: float) -> Flags:
    """Where (N,) an edge (N,) [m] does not go on from its neighbours, to a tolerance (N,) [m].

    Single ones, and short stretches that begin and end with a jump, as where a reflection runs
    along the side of a bead.
    """
    single = np.abs(distance - running_median(distance, 5)) > tolerance
    jump = np.abs(np.diff(distance)) > np.maximum(tolerance[1:], spacing)
    unknown = np.isnan(distance)
    border = np.concatenate(([True], jump | unknown[1:] | unknown[:-1]))
    stretch = np.cumsum(border) - 1
    length = np.bincount(stretch)[stretch] * spacing
    jumps = np.bincount(stretch, np.concatenate(([False], jump)), len(border))
    # A stretch begins with its own jump, and ends with that of the next.
    ends = np.append(jumps[1:], 0.0)
    return single | ((length < ISLAND) & (jumps > 0)[stretch] & (ends > 0)[stretch])


def smoothed(values: Array, passes: int) -> Array:
    """Values (N,) with 1/4 of each neighbour's mixed in, so often, less near unknown ones."""
    result = values.copy()
    inner = np.isfinite(values)
    for _ in range(passes):
        inner[1:-1] &= inner[:-2] & inner[2:]
        inner[[0, -1]] = False
        middle = (result[:-2] + 2 * result[1:-1] + result[2:]) / 4
        result[1:-1][inner[1:-1]] = middle[inner[1:-1]]
    return result


def smoothing_passes(distance: Array, spacing: float) -> int:
    """How often edges (N,) of a bead [m] are to be smoothed: each adds 1/2 to the variance.

    Surface tension levels what is shorter than a bead is wide (Plateau and Rayleigh); what is
    as long loses a quarter, what is twice as long a fourteenth.
    """
    known = distance[np.isfinite(distance)]
    if len(known) == 0:
        return 0
    sigma = SMOOTHING * 2 * float(np.median(known)) / spacing
    return min(round(2 * sigma**2), MAXIMUM_PASSES)


def sorted_quantile(ordered: Floats, part: float) -> Array:
    """Quantile (N,) of sorted rows (N, K), linear between neighbours, as np.quantile gives it."""
    place = part * (ordered.shape[1] - 1)
    low = int(place)
    high = min(low + 1, ordered.shape[1] - 1)
    return np.asarray((1 - place + low) * ordered[:, low] + (place - low) * ordered[:, high],
                      np.float64)


def refine(share: Floats, first: Index, noise: Array) -> tuple[Array, Array]:
    """Where (N,) shares (N, K) pass half-way between the levels on either side, and how steeply.

    Levels are read beside the edge itself, since light, shade and a camera's blur near the
    end of a run change them from place to place; and again from where that moves the edge to. The
    half-way crossing is then moved to where as much ink lies outside as bed inside, which
    holds for whole pixels as well. In samples from the path; NaN = no edge.
    """
    near = round(PLATEAU[0] / STEP)
    start = first.copy()
    crossing, outer, step, slope = np.full((4, len(share)), np.nan)
    moved = np.arange(len(share))
    for _ in range(PASSES):
        found = half_way(share[moved], start[moved], noise[moved])
        crossing[moved], outer[moved], step[moved], slope[moved] = found
        before = start[moved]
        start[moved] = np.where(np.isfinite(found[0]), np.ceil(found[0]), 1).astype(np.intp)
        # From the same place the same would be found again.
        moved = moved[start[moved] != before]

    row = np.arange(len(share))[:, None]
    reach = np.linspace(-near, near, 4 * near + 1)
    place = np.where(np.isfinite(crossing), crossing, 1.0)[:, None] + reach
    base = np.floor(place).astype(np.intp)
    part = place - base
    low, high = (share[row, np.clip(base + ahead, 0, share.shape[1] - 1)] for ahead in (0, 1))
    values = (1 - part) * low + part * high
    values = (values - outer[:, None]) / step[:, None] - 0.5
    surplus = trapezoid(values, reach, axis=1)
    shift = surplus / np.maximum(values[:, 0] - values[:, -1], 0.5)
    return crossing + np.clip(np.nan_to_num(shift), -1.0, 1.0), slope * step


def half_way(share: Floats, start: Index, noise: Array) -> tuple[Array, Array, Array, Array]:
    """Where (N,) shares (N, K) pass half-way between the levels beside a place (N,).

    Also (N,) the level outside, that inside less it, and the slope as a part of that; NaN = none.
    """
    near, far = (round(distance / STEP) for distance in PLATEAU)
    row, start = np.arange(len(share)), start[:, None]
    around = np.clip(start + np.arange(-far - 1, far + 1), 0, share.shape[1] - 1)
    window = share[row[:, None], around]
    plateau = far - near + 1
    # What glare hides of the ink is taken for ink.
    inside = np.sort(np.nan_to_num(window[:, :plateau], nan=1.0), axis=1)
    # A reflection near the edge takes away from the ink: then what it leaves counts.
    fullest = sorted_quantile(inside, 0.9) - np.maximum(0.1, 2 * noise)
    inner = np.maximum(sorted_quantile(inside, 0.5), fullest)
    outside = np.sort(window[:, -plateau:], axis=1)  # with NaN last
    outer = np.where(np.isnan(outside[:, -1]), np.nan, sorted_quantile(outside, 0.5))
    step = np.where((inner - outer > 0.3) & (inner > 0.3) & (outer < 0.5), inner - outer, np.nan)
    index = start + np.arange(-near - 1, near + 1)
    values = window[:, far - near:far + near + 2]
    values = (values - outer[:, None]) / step[:, None] - 0.5
    falls = (values[:, :-1] >= 0) & (values[:, 1:] < 0)
    nearest = np.argmin(np.where(falls, np.abs(index[:, :-1] + 0.5 - start), np.inf), axis=1)
    above, below = (values[row, nearest + ahead] for ahead in (0, 1))
    slope = np.where(falls.any(axis=1), above - below, np.nan)
    return index[row, nearest] + above / slope, outer, step, slope
