"""How much ink lies where: of a stroke, a layer or a print, beside what was commanded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import runs
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile

LEAST_KNOWN = 0.5  # share of a stroke whose area is known, to tell its volume
COMMON_SIGMA = 0.03  # of an area, as a share of it, that is alike along a whole print
STEADY_M = 1.4e-3  # of path, along which the errors of areas are alike
UNKNOWN_SPREAD = 0.1  # of an area that is not known, as a share of those that are


@dataclass(frozen=True)
class Amount:
    """What lies along a part of a print.

    Attributes:
        length: of path on which ink was commanded [m].
        known: share of it whose cross-section is known; NaN without any.
        thickness, height, area: means over what is measured [m, m, m^2]; NaN without any.
        volume, volume_sigma: of the ink above what lay there before, with its 1-sigma uncertainty
            [m^3]. What is not known counts as the rest; NaN where that is more than half.
        commanded: volume that the extruder was told to push out [m^3]; NaN = not known.
        delivered, delivered_sigma: volume as a share of what was commanded where it is known.
    """

    length: float
    known: float
    thickness: float
    height: float
    area: float
    volume: float
    volume_sigma: float
    commanded: float
    delivered: float
    delivered_sigma: float


def amount_of(profile: ThicknessProfile, chosen: Flags) -> Amount:
    """Return what lies along chosen samples (N,) of strokes."""
    chosen = chosen & (profile.stroke > 0)
    step = lengths(profile.arc_length, profile.stroke)[chosen]
    area, sigma = profile.area[chosen], np.nan_to_num(profile.area_sigma[chosen])
    told = profile.commanded_area[chosen]
    length, known = float(step.sum()), np.isfinite(area)
    seen = float(step[known].sum())
    volume = volume_sigma = delivered = delivered_sigma = np.nan
    if seen > 0 and seen >= LEAST_KNOWN * length:
        there = float((area * step)[known].sum())
        volume = there * length / seen
        alike = np.sqrt(min(1.0, STEADY_M / seen)) * float((sigma * step)[known].sum())
        relative = np.hypot(alike / there, COMMON_SIGMA) if there > 0 else np.nan
        missing = UNKNOWN_SPREAD * volume * (1 - seen / length)
        volume_sigma = float(np.hypot(volume * relative, missing))
        pushed = float((told * step)[known].sum())
        if pushed > 0:
            delivered = there / pushed
            delivered_sigma = delivered * float(relative)
    measured = profile.status[chosen] == Status.MEASURED
    return Amount(
        length=length, known=seen / length if length > 0 else np.nan,
        thickness=_mean(profile.thickness[chosen][measured]),
        height=_mean(profile.height[chosen][measured]), area=_mean(area[measured]),
        volume=volume, volume_sigma=volume_sigma, commanded=float((told * step).sum()),
        delivered=delivered, delivered_sigma=delivered_sigma)


def commanded_area(path: DepositionPath, stroke: Index) -> Array:
    """Return the volume of ink that was commanded per length (N,) of a path [m^2].

    NaN where it is not known, and where the nozzle stood; 0 on travel.

    Args:
        path: N points.
        stroke: (N,) number of the stroke of each; 0 = travel.
    """
    step, lasted = lengths(path.arc_length, stroke), lengths(path.time, stroke)
    with np.errstate(invalid='ignore', divide='ignore'):
        area = np.where(step > 0, path.flow_rate * lasted / step, np.nan)
    return np.where(stroke > 0, area, 0.0)


def lengths(along: Array, stroke: Index) -> Array:
    """Return how much each of N samples stands for: half-way to its neighbours in its stroke.

    A stroke ends somewhere between its last sample and the next place of one.

    Args:
        along: (N,) arc lengths or times, increasing.
        stroke: (N,) number of the stroke of each.
    """
    first, end = runs(stroke)
    place = np.arange(len(along))
    before = along - along[np.maximum(place - 1, first)]
    behind = along[np.minimum(place + 1, end - 1)] - along
    return np.asarray((np.where(before > 0, before, behind)
                       + np.where(behind > 0, behind, before)) / 2)


def _mean(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else np.nan
