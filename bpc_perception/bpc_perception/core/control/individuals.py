"""Limits of a control chart of individual values, one a print.

[NIST/SEMATECH e-Handbook of Statistical Methods, 6.3.2.2: individuals control charts]
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array

FEWEST_PRINTS = 10  # as in the example of the handbook; from fewer the limits are a guess
D2 = 1.128  # mean range of two normal values, in standard deviations
LIMIT_SIGMAS = 3.0


@dataclass(frozen=True)
class ControlLimits:
    """Between which values a print is like those of the baseline.

    Attributes:
        centre: mean of the baseline, in the unit of the values; NaN = no limits.
        sigma: standard deviation from print to print, in the same unit; NaN = no limits.
        count: number of prints in the baseline whose value is known.
        reason: why there are no limits; empty = there are.
    """

    centre: float
    sigma: float
    count: int
    reason: str = ''

    @property
    def lower(self) -> float:
        """Three standard deviations below the centre."""
        return self.centre - LIMIT_SIGMAS * self.sigma

    @property
    def upper(self) -> float:
        """Three standard deviations above the centre."""
        return self.centre + LIMIT_SIGMAS * self.sigma


def control_limits(values: Array, baseline: int | None = None) -> ControlLimits:
    """Return the limits that a baseline of prints sets.

    The standard deviation is the mean difference of neighbours by 1.128, which a drift hardly
    changes: the deviation of all from their mean would hide the drift in wider limits.

    Args:
        values: (N,) one a print, in the order of time; NaN = not known.
        baseline: the first so many prints; None = all.
    """
    known = values[:baseline]
    known = known[np.isfinite(known)]
    count = len(known)
    if count < FEWEST_PRINTS:
        return ControlLimits(np.nan, np.nan, count, f'limits need {FEWEST_PRINTS} prints, '
                             f'the baseline has {count}')
    sigma = float(np.abs(np.diff(known)).mean()) / D2
    if not sigma > 0:
        return ControlLimits(np.nan, np.nan, count, 'all prints of the baseline are the same')
    return ControlLimits(float(known.mean()), sigma, count)
