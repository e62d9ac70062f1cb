"""The schedule that is in force along the path of a print, as advice needs it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.arrays import Array
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.targets import WidthTargets


@dataclass(frozen=True)
class Planned:
    """Factors of the schedule along a path of N points.

    What a schedule corrects is not for advice to correct: it sees the command divided by the
    factors, and widths per what is wanted, as if the print were set up to make it everywhere.

    Attributes:
        factor: (N,) on the flow; 1 where none was scheduled.
        since: arc length from which on there is a schedule [m].
        ahead: least and largest factor that comes while advice holds.
        sigma: standard deviation of the logarithm of all factors together.
    """

    factor: Array
    since: float
    ahead: tuple[float, float]
    sigma: float

    def without(self, path: DepositionPath) -> DepositionPath:
        """Return a path that begins as this one, with its rates divided by the factors."""
        factor = self.factor
        return replace(path, flow_rate=path.flow_rate / factor,
                       plunger_velocity=path.plunger_velocity / factor)

    def levelled(self, profile: ThicknessProfile, targets: WidthTargets) -> ThicknessProfile:
        """Return a profile as if the same width were wanted everywhere as where it begins."""
        ratio = targets.at(self.since) / targets.at(profile.arc_length)
        return replace(profile, thickness=profile.thickness * ratio, sigma=profile.sigma * ratio,
                       area=profile.area * ratio**2, area_sigma=profile.area_sigma * ratio**2)

    def restored(self, advice: RateAdvice, targets: WidthTargets) -> RateAdvice:
        """Return advice on a levelled profile with the widths that are wanted where it looked."""
        ratio = float(targets.at(advice.window[1]) / targets.at(self.since))
        if np.isnan(ratio):
            return advice
        return replace(advice, target_thickness=advice.target_thickness * ratio,
                       measured_thickness=advice.measured_thickness * ratio,
                       expected_thickness=advice.expected_thickness * ratio,
                       measured_area=advice.measured_area * ratio**2)
