"""How uniform a filament is."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets

TOLERANCE = 0.1  # share of the reference


class Uniformity(NamedTuple):
    """How uniform a filament is; NaN where nothing was measured.

    Attributes:
        variation: coefficient of variation: standard deviation by mean of the MEASURED samples.
        within: share of the known samples, MEASURED or GAP, whose thickness is within TOLERANCE of
            the reference. A gap never is.
    """

    variation: float
    within: float


def reference(profile: ThicknessProfile, targets: WidthTargets | None) -> Array:
    """Return what thickness is compared with, (N,) [m]: the target, else the measured median."""
    if targets is not None:
        return targets.at(profile.arc_length)
    return np.full(len(profile), profile.summary.thickness_median)


def uniformity(profile: ThicknessProfile, targets: WidthTargets | None) -> Uniformity:
    """Return how uniform the filament of a profile is."""
    summary = profile.summary
    known = np.isin(profile.status, (Status.MEASURED, Status.GAP))
    if not summary.thickness_mean > 0:
        return Uniformity(np.nan, np.nan)
    wanted = reference(profile, targets)
    within = np.abs(profile.thickness - wanted) <= TOLERANCE * wanted
    return Uniformity(summary.thickness_std / summary.thickness_mean, float(within[known].mean()))
