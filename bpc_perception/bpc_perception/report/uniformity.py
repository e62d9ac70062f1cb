"""How even a filament came out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile

TOLERANCE = 0.1  # of the thickness wanted


class Uniformity(NamedTuple):
    """How even a filament is; NaN where nothing was measured.

    Attributes:
        variation: coefficient of variation: standard deviation by mean of the MEASURED samples.
        within: share of the known samples, MEASURED or GAP, whose thickness is within TOLERANCE of
            the reference. A gap never is.
    """

    variation: float
    within: float


def reference(profile: ThicknessProfile, targets: WidthTargets | None) -> Array:
    """What the thickness is held against, (N,) [m]: the target, else the median measured."""
    if targets is not None:
        return targets.at(profile.arc_length)
    return np.full(len(profile), profile.summary.thickness_median)


def uniformity(profile: ThicknessProfile, targets: WidthTargets | None) -> Uniformity:
    """How even the filament of a profile is."""
    found = profile.summary
    known = np.isin(profile.status, (Status.MEASURED, Status.GAP))
    if not found.thickness_mean > 0:
        return Uniformity(np.nan, np.nan)
    wanted = reference(profile, targets)
    near = np.abs(profile.thickness - wanted) <= TOLERANCE * wanted
    return Uniformity(found.thickness_std / found.thickness_mean, float(near[known].mean()))
