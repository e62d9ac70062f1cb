"""How ink differs from bed in a print as a whole, and how colours vary."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtr, gammaincinv

from bpc_perception.core.arrays import Array

ROUNDING = 0.5  # sigma of rounding to whole grey levels, and some more [grey levels]
FEWEST_COLOURS = 10  # from which a covariance is made


@dataclass(frozen=True)
class Contrast:
    """How ink differs from bed.

    Attributes:
        clearance: from which distance to all of the path bed is sure, if only because there is
            no more [m].
        bed: (3,) colour of the bed, in the middle of the print's light and shade.
        step: (3,) from the colour of the bed to that of the ink.
        bed_spread, spread: (3, 3) how colours vary within the bed, and within both.
    """

    clearance: float
    bed: Array
    step: Array
    bed_spread: Array
    spread: Array


def core_covariance(residual: NDArray[np.floating[Any]], core: float) -> Array:
    """Return the covariance (3, 3) of colours, from the inner share ``core`` of residuals (K, 3).

    It is as large as if all were normally distributed, of which a core shows less, and never 0.
    """
    floor = np.eye(3) * ROUNDING**2
    size = np.linalg.norm(residual, axis=1)
    known = np.isfinite(size)
    residual, size = residual[known], size[known]
    if len(residual) < FEWEST_COLOURS:
        return floor
    inner = residual[size <= np.quantile(size, core)]
    return np.asarray(inner.T @ inner / len(inner) / _variance_of_core(core) + floor)


@cache
def _variance_of_core(core: float) -> float:
    """Return the share of a 3-D normal distribution's variance that its inner ``core`` has."""
    # With scipy.stats, a command takes half a second longer to start.
    return float(chdtr(5, 2 * gammaincinv(3 / 2, core)) / core)
