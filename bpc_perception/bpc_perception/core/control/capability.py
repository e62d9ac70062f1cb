"""Process capability: how much room there is between the prints' spread and the tolerance.

[NIST/SEMATECH e-Handbook of Statistical Methods, 6.1.6; A. F. Bissell, How reliable is your
capability index?, Applied Statistics 39 (1990) 331]
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import betaincinv, chdtri, ndtri

from bpc_perception.core.arrays import Array
from bpc_perception.core.control.individuals import FEWEST_PRINTS

CONFIDENCE = 0.95  # of the bounds, which are two-sided


@dataclass(frozen=True)
class Capability:
    """How well a process keeps a tolerance.

    Attributes:
        cp: width of the tolerance per six standard deviations, as if the mean were in its middle.
        cp_bounds: (2,) between which it lies at 95 % confidence.
        cpk: distance of the mean from the nearer end of the tolerance, per three of them.
        cpk_bounds: (2,) the same of it.
        mean, sigma: of the values, with all that changed over them, in their unit.
        count: number of values.
        reason: why there are no numbers: each of them is NaN; empty = there are.
    """

    cp: float
    cp_bounds: tuple[float, float]
    cpk: float
    cpk_bounds: tuple[float, float]
    mean: float
    sigma: float
    count: int
    reason: str = ''


def capability(values: Array, tolerance: tuple[float, float]) -> Capability:
    """Return the capability of a process from its values.

    Args:
        values: (N,) one a print; NaN = not known.
        tolerance: least and largest value allowed, in the unit of the values; NaN = none.
    """
    known = values[np.isfinite(values)]
    count, (low, high) = len(known), tolerance
    mean = float(known.mean()) if count else np.nan
    sigma = float(known.std(ddof=1)) if count > 1 else np.nan
    reason = ('no tolerance' if not low < high else
              f'Cp needs {FEWEST_PRINTS} prints, there are {count}' if count < FEWEST_PRINTS else
              'all prints are the same' if not sigma > 0 else '')
    if reason:
        none = (np.nan, np.nan)
        return Capability(np.nan, none, np.nan, none, mean, sigma, count, reason)
    free, outside = count - 1, (1 - CONFIDENCE) / 2
    cp = (high - low) / (6 * sigma)
    cpk = min(high - mean, mean - low) / (3 * sigma)
    # chdtri inverts the right tail of chi squared.
    cp_bounds = (cp * np.sqrt(chdtri(free, 1 - outside) / free),
                 cp * np.sqrt(chdtri(free, outside) / free))
    half = -ndtri(outside) * np.sqrt(1 / (9 * count) + cpk**2 / (2 * free))
    return Capability(cp, (float(cp_bounds[0]), float(cp_bounds[1])), cpk,
                      (float(cpk - half), float(cpk + half)), mean, sigma, count)


def share_bounds(good: int, count: int) -> tuple[float, float]:
    """Return between which shares that of good prints lies at 95 % confidence; NaN of none.

    [C. J. Clopper, E. S. Pearson, Biometrika 26 (1934) 404]
    """
    if not count:
        return np.nan, np.nan
    outside = (1 - CONFIDENCE) / 2
    return (float(betaincinv(good, count - good + 1, outside)) if good else 0.0,
            float(betaincinv(good + 1, count - good, 1 - outside)) if good < count else 1.0)
