"""As much of a profile as a screen can show: its size does not grow with the print."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.display.legend import as_shown

MOST_POINTS, MOST_STRETCHES = 1200, 150  # that are drawn
KEPT_OF_BUCKET = 3  # the least, the largest, and one that interrupts the line


@dataclass(frozen=True)
class Curve:
    """Thickness over arc length, each (M,) [m].

    Attributes:
        arc_length: in order.
        thickness, sigma: NaN where the line is interrupted.
        height: of the ink; NaN where it is not known.
    """

    arc_length: Array
    thickness: Array
    sigma: Array
    height: Array


@dataclass(frozen=True)
class Stretch:
    """Arc length from start to end [m] over which there is no thickness, and why."""

    status: Status
    start: float
    end: float


def thinned(profile: ThicknessProfile, start: float = 0.0, most: int = MOST_POINTS,
            end: float = np.inf) -> Curve:
    """Return the measured samples between arc lengths, no more than a screen can show.

    No extreme and no interruption is lost.

    Args:
        profile: with N samples.
        start: arc length [m].
        most: number of points, 3 or more.
        end: arc length [m].
    """
    first = int(np.searchsorted(profile.arc_length, start))
    behind = int(np.searchsorted(profile.arc_length, end, side='right'))
    arc_length, sigma, height = (values[first:behind] for values in (
        profile.arc_length, profile.sigma, profile.height))
    thickness = np.where(profile.status[first:behind] == Status.MEASURED,
                         profile.thickness[first:behind], np.nan)
    if len(thickness) > most:
        kept = _kept(thickness, most)
        arc_length, thickness, sigma, height = (
            values[kept] for values in (arc_length, thickness, sigma, height))
    sigma, height = (np.where(np.isnan(thickness), np.nan, values) for values in (sigma, height))
    return Curve(arc_length, thickness, sigma, height)


def _kept(thickness: Array, most: int) -> NDArray[np.intp]:
    """Return which samples (K,) of thickness (N,) stay, with K up to ``most``.

    They are KEPT_OF_BUCKET samples of each bucket, which is a run of neighbours.
    """
    size = -(-len(thickness) // (most // KEPT_OF_BUCKET))
    padded = np.full(-(-len(thickness) // size) * size, np.nan)
    padded[:len(thickness)] = thickness
    buckets = padded.reshape(-1, size)
    in_bucket = (np.where(np.isnan(buckets), np.inf, buckets).argmin(axis=1),
                 np.where(np.isnan(buckets), -np.inf, buckets).argmax(axis=1),
                 np.isnan(buckets).argmax(axis=1))
    starts = np.arange(len(buckets)) * size
    kept = np.unique(np.concatenate([starts + index for index in in_bucket]))
    return kept[kept < len(thickness)]


def stretches(profile: ThicknessProfile, start: float = 0.0,
              most: int = MOST_STRETCHES) -> list[Stretch]:
    """Return the stretches without a thickness that end behind an arc length [m], in order.

    Of more than ``most`` it returns the longest.
    """
    profile = as_shown(profile)
    all_stretches = [
        Stretch(status, max(float(low), start), float(high))
        for status in Status if status != Status.MEASURED
        for low, high in profile.extents(status)
        if high > start]
    all_stretches.sort(key=lambda stretch: stretch.start - stretch.end)
    return sorted(all_stretches[:most], key=lambda stretch: stretch.start)
