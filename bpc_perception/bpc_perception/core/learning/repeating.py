"""What repeats from layer to layer, told apart from what is chance.

Each layer gives a curve: the logarithm of the ink that has to arrive. It is split into its level,
a slow part and a fast one. Of each part as much is believed as repeats:

- The level counts as far as it is surely off what the print was set up for.
- From two layers on, a part counts by its reliability: its covariance between layers over its
  variance; that of a mean of several is Spearman's and Brown's [Brit. J. Psychology 3, 1910].
- In one layer alone nothing repeats. Its fast part counts for nothing, its slow one as far as it
  is larger than unevenness of the fast part's size makes it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from bpc_perception.core.advice.delivery_filter import CORRELATION_LENGTH_M, PRIOR_SIGMA
from bpc_perception.core.arrays import Array

STEP_M = 2.5e-4  # between the places at which curves are given
SLOW_M = 0.01  # standard deviation of the window that makes the slow part
FAST_M = 2.5e-4  # of that which smooths the fast one
# Variance of the slow part of unevenness with the correlation length, over that of its fast part.
SLOW_SHARE = 0.5
SLOW_CORRELATION_M = (2 * np.pi)**0.5 * SLOW_M  # of two slow parts: integral of its square
SURE_SIGMAS = 2.0  # of what chance makes
LEVEL_DOUBT = 1.0  # standard deviations of the level that are left out
KEPT = 0.7  # what a layer counts, per layer that came after it
LEAST_WEIGHT = 0.05  # of known places under a window
MAD_SIGMA = 1.4826  # standard deviation over the median absolute deviation


@dataclass(frozen=True)
class Repeating:
    """The part of K places' curves that is expected to come again.

    Attributes:
        value: (K,) logarithm.
        sigma: standard deviation of the value at a place.
        level_sigma: the same of its level.
        share: of the fast part that repeats, 0 to 1; 0 with a single layer.
    """

    value: Array
    sigma: float
    level_sigma: float
    share: float


def repeating(curves: Array, prior: float) -> Repeating:
    """Return what repeats of curves (L, K), the newest last; NaN = not known.

    Args:
        curves: of L layers at K places, ``STEP_M`` apart.
        prior: the level that the print was set up for.
    """
    level = np.nanmedian(curves, axis=1)
    centred = curves - level[:, None]
    slow: Array = _smooth(centred, SLOW_M)
    fast = _smooth(centred - slow, FAST_M)
    weight: Array = np.power(KEPT, np.arange(len(curves))[::-1])
    weight = np.asarray(weight / weight.sum(), float)
    scatter = np.array([MAD_SIGMA**2 * np.nanmedian(one**2) for one in centred - slow])
    chance = SLOW_SHARE * scatter
    slow_size = np.nanmean(slow**2, axis=1)
    larger = float(np.clip(1 - chance.mean() / max(slow_size.mean(), 1e-12), 0.0, 1.0))
    share_slow = min(_reliability(slow, weight, larger, SLOW_CORRELATION_M), larger)
    share_fast = _reliability(fast, weight, 0.0, CORRELATION_LENGTH_M)
    length = STEP_M * np.isfinite(curves).sum(axis=1)
    level_variance = float(np.sum(
        weight**2 * 2 * (scatter + chance) * CORRELATION_LENGTH_M / length))
    trust = PRIOR_SIGMA**2 / (PRIOR_SIGMA**2 + level_variance)
    level_sigma = float(np.sqrt(trust * level_variance))
    off = trust * (float(weight @ level) - prior)
    value = (prior + np.sign(off) * max(abs(off) - LEVEL_DOUBT * level_sigma, 0.0)
             + share_slow * _mean(slow, weight) + share_fast * _mean(fast, weight))
    left = ((1 - share_slow) * slow_size.mean()
            + (1 - share_fast) * float(np.nanmean(fast**2)))
    sigma = float(np.sqrt(level_sigma**2 + left))
    return Repeating(value, sigma, level_sigma, share_fast)


def _smooth(curves: Array, length: float) -> Array:
    """Return curves (L, K) under a Gaussian window [m]; NaN where too little is known."""
    known = np.isfinite(curves)
    filled = np.where(known, curves, 0.0)
    window = {'sigma': length / STEP_M, 'axis': 1, 'mode': 'constant', 'truncate': 4.0}
    total = gaussian_filter1d(filled, **window)
    weight = gaussian_filter1d(known.astype(float), **window)
    return np.where(weight > LEAST_WEIGHT, total / np.maximum(weight, LEAST_WEIGHT), np.nan)


def _reliability(parts: Array, weight: Array, one: float, length: float) -> float:
    """Return which share of the weighted mean of parts (L, K) repeats; ``one`` for a single.

    What chance makes of independent parts, correlated over a length [m], counts for nothing.
    """
    if len(parts) == 1:
        return one
    pairs = list(combinations(range(len(parts)), 2))
    together = np.nanmean([np.nanmean(parts[first] * parts[second]) for first, second in pairs])
    share = float(np.clip(together / np.nanmean(parts**2), 0.0, 1.0))
    independent = len(pairs) * STEP_M * np.isfinite(parts).all(axis=0).sum() / length
    if share * independent**0.5 < SURE_SIGMAS:
        return 0.0
    return 1 / (1 + (1 - share) / share * float(np.sum(weight**2)))


def _mean(parts: Array, weight: Array) -> Array:
    """Return the weighted mean (K,) of what is known of parts (L, K); 0 where nothing is."""
    known = np.isfinite(parts)
    total = (np.where(known, parts, 0.0) * weight[:, None]).sum(axis=0)
    among = (known * weight[:, None]).sum(axis=0)
    return np.asarray(np.divide(total, among, out=np.zeros_like(total), where=among > 0))
