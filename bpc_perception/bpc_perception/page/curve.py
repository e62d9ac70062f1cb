"""As much of a profile as a screen can show: its size does not grow with the print."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import run_extents, Status, ThicknessProfile

POINTS, STRETCHES = 1200, 150  # drawn at most


@dataclass(frozen=True)
class Curve:
    """Thickness over arc length, each (M,) [m].

    Attributes:
        arc_length: in order.
        thickness, sigma: NaN where the line is interrupted.
    """

    arc_length: Array
    thickness: Array
    sigma: Array


@dataclass(frozen=True)
class Stretch:
    """Arc length from start to end [m] over which there is no thickness, and why."""

    status: Status
    start: float
    end: float


def thinned(profile: ThicknessProfile, start: float = 0.0, most: int = POINTS) -> Curve:
    """The measured samples from an arc length [m] on, at most so many (of 3 or more).

    Of each bucket of neighbours the least, the largest and one that interrupts the line stay, so
    that no extreme and no interruption is lost.
    """
    first = int(np.searchsorted(profile.arc_length, start))
    arc_length, sigma = profile.arc_length[first:], profile.sigma[first:]
    thickness = np.where(profile.status[first:] == Status.MEASURED, profile.thickness[first:],
                         np.nan)
    if len(thickness) > most:
        size = -(-len(thickness) // (most // 3))
        padded = np.full(-(-len(thickness) // size) * size, np.nan)
        padded[:len(thickness)] = thickness
        buckets = padded.reshape(-1, size)
        chosen = [np.where(np.isnan(buckets), np.inf, buckets).argmin(axis=1),
                  np.where(np.isnan(buckets), -np.inf, buckets).argmax(axis=1),
                  np.isnan(buckets).argmax(axis=1)]
        starts = np.arange(len(buckets)) * size
        kept = np.unique(np.concatenate([starts + each for each in chosen]))
        kept = kept[kept < len(thickness)]
        arc_length, thickness, sigma = arc_length[kept], thickness[kept], sigma[kept]
    return Curve(arc_length, thickness, np.where(np.isnan(thickness), np.nan, sigma))


def stretches(profile: ThicknessProfile, start: float = 0.0,
              most: int = STRETCHES) -> list[Stretch]:
    """The stretches without a thickness that end behind an arc length [m]; of many the longest."""
    found = [Stretch(status, max(float(low), start), float(high))
             for status in Status if status != Status.MEASURED
             for low, high in run_extents(profile.status == status, profile.arc_length)
             if high > start]
    found.sort(key=lambda stretch: stretch.start - stretch.end)
    return sorted(found[:most], key=lambda stretch: stretch.start)
