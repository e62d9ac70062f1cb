"""Where a share of ink passes half-way between the levels on either side of an edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Floats, Index
from bpc_perception.core.measurement.cross_section.sections.sections import SAMPLE_STEP_PX

PLATEAU_PX = (1.5, 3.5)  # from the edge to where its two levels are read
NEAR, FAR = (round(distance / SAMPLE_STEP_PX) for distance in PLATEAU_PX)  # the same in samples
ROUNDS = 3  # of reading levels and moving the edge
# A quantile of the ink beside an edge shows its level in spite of a reflection. From it is taken
# the larger of this share and this multiple of the noise.
FULLEST = 0.9
FULLEST_LESS, FULLEST_LESS_NOISE = 0.1, 2.0
LEAST_STEP, LEAST_INNER, MOST_OUTER = 0.3, 0.3, 0.5  # of shares of ink, that make an edge
MOST_SHIFT = 1.0  # from the half-way crossing to where ink outside and bed inside agree [samples]


@dataclass(frozen=True)
class Crossings:
    """Half-way crossings of N rows; NaN = none.

    Attributes:
        place: (N,) [samples from the path].
        outer: (N,) share of ink outside of it.
        step: (N,) share inside less that outside.
        slope: (N,) how steeply the share falls there [steps a sample].
    """

    place: Array
    outer: Array
    step: Array
    slope: Array


def find_crossing(share: Floats, first: Index, end: Index,
                  noise: Array) -> tuple[Array, Array]:
    """Find where shares pass half-way between the levels on either side, and how steeply.

    The half-way crossing is moved to where as much ink lies outside as bed inside, which holds
    for whole pixels as well.

    Args:
        share: (N, K) of ink in samples outward from the path.
        first: (N,) sample near which the edge is.
        end: (N,) first sample from which on another pass comes nearer: no level is read there.
        noise: (N,) 1-sigma noise of a share.

    Returns:
        Place (N,) [samples from the path] and slope (N,) [share a sample]; NaN = no edge.
    """
    found = settle(share, first, end, noise)
    row = np.arange(len(share))[:, None]
    reach = np.linspace(-NEAR, NEAR, 4 * NEAR + 1)
    place = np.where(np.isfinite(found.place), found.place, 1.0)[:, None] + reach
    base = np.floor(place).astype(np.intp)
    part = place - base
    low, high = (share[row, np.clip(base + ahead, 0, share.shape[1] - 1)] for ahead in (0, 1))
    values = (1 - part) * low + part * high
    values = (values - found.outer[:, None]) / found.step[:, None] - 0.5
    surplus = (np.diff(reach) * (values[:, 1:] + values[:, :-1]) / 2).sum(axis=1)
    shift = surplus / np.maximum(values[:, 0] - values[:, -1], 0.5)
    return (found.place + np.clip(np.nan_to_num(shift), -MOST_SHIFT, MOST_SHIFT),
            found.slope * found.step)


def settle(share: Floats, first: Index, end: Index, noise: Array) -> Crossings:
    """Find half-way crossings, and again with the levels beside where they are found.

    Light, shade, and a camera's blur near the end of a run change the levels from place to place.
    """
    start = first.copy()
    place, outer, step, slope = np.full((4, len(share)), np.nan)
    moved = np.arange(len(share))
    for _ in range(ROUNDS):
        found = half_way(share[moved], start[moved], end[moved], noise[moved])
        place[moved], outer[moved] = found.place, found.outer
        step[moved], slope[moved] = found.step, found.slope
        before = start[moved]
        start[moved] = np.where(
            np.isfinite(found.place), np.ceil(found.place), 1).astype(np.intp)
        # From the same place the same would be found again.
        moved = moved[start[moved] != before]
    return Crossings(place, outer, step, slope)


def half_way(share: Floats, start: Index, end: Index, noise: Array) -> Crossings:
    """Find where shares (N, K) pass half-way between the levels beside a sample (N,)."""
    row, start = np.arange(len(share)), start[:, None]
    last = np.clip(end, 1, share.shape[1])[:, None] - 1
    around = np.clip(start + np.arange(-FAR - 1, FAR + 1), 0, last)
    window = share[row[:, None], around]
    inner, outer = levels(window, noise)
    edge = (inner - outer > LEAST_STEP) & (inner > LEAST_INNER) & (outer < MOST_OUTER)
    step = np.where(edge, inner - outer, np.nan)
    index = start + np.arange(-NEAR - 1, NEAR + 1)
    values = window[:, FAR - NEAR:FAR + NEAR + 2]
    values = (values - outer[:, None]) / step[:, None] - 0.5
    falls = (values[:, :-1] >= 0) & (values[:, 1:] < 0)
    nearest = np.argmin(np.where(falls, np.abs(index[:, :-1] + 0.5 - start), np.inf), axis=1)
    above, below = (values[row, nearest + ahead] for ahead in (0, 1))
    slope = np.where(falls.any(axis=1), above - below, np.nan)
    return Crossings(index[row, nearest] + above / slope, outer, step, slope)


def levels(window: Floats, noise: Array) -> tuple[Array, Array]:
    """Read the levels (N,) inside and outside of an edge in the middle of a window (N, J)."""
    plateau = FAR - NEAR + 1
    # What glare hides of the ink is taken for ink.
    inside = window[:, :plateau].copy()
    inside[np.isnan(inside)] = 1.0
    inside.sort(axis=1)
    # A reflection near the edge takes away from the ink: then what it leaves counts.
    fullest = (sorted_quantile(inside, FULLEST)
               - np.maximum(FULLEST_LESS, FULLEST_LESS_NOISE * noise))
    inner = np.maximum(sorted_quantile(inside, 0.5), fullest)
    outside = np.sort(window[:, -plateau:], axis=1)  # with NaN last
    outer = np.where(np.isnan(outside[:, -1]), np.nan, sorted_quantile(outside, 0.5))
    return inner, outer


def sorted_quantile(ordered: Floats, part: float) -> Array:
    """Return the quantile (N,) of sorted rows (N, K), as np.quantile interpolates it."""
    place = part * (ordered.shape[1] - 1)
    low = int(place)
    high = min(low + 1, ordered.shape[1] - 1)
    return np.asarray((1 - place + low) * ordered[:, low] + (place - low) * ordered[:, high],
                      np.float64)
