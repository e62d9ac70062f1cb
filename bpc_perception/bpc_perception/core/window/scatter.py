"""How much lines differ from each other beyond what their uncertainties tell."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import chi2

from bpc_perception.core.arrays import Array

LEAST_SCATTER = 1e-4  # of a line against others: none is laid more evenly [share]
LARGEST_SCATTER = 1.0
PARTS = 20  # of equal probability, into which what the scatter may be is divided


def scatter_of(values: Array, terms: Array, sigma: Array) -> float:
    """Return the standard deviation τ from line to line, as large as it has to be expected.

    With the true τ, Q = Σ r² / (σ² + τ²) has the chi-squared distribution of the degrees of
    freedom [Viechtbauer 2007]. So each quantile of that stands for a τ, and the root mean square
    of all is returned. A new line is then as good as normally distributed, although τ is known
    from few lines [Nagashima et al. 2019]: of exact widths this is the variance of Student's t.

    Args:
        values: (N,) logarithms that a model explains.
        terms: (N, P) of the model.
        sigma: (N,) own uncertainty of each value.
    """
    quantiles = (np.arange(PARTS) + 0.5) / PARTS
    sums = chi2.ppf(quantiles, len(values) - terms.shape[1])
    each = [_scatter_with(float(wanted), values, terms, sigma) for wanted in sums]
    return float(np.sqrt(np.mean(np.square(each))))


def _scatter_with(wanted: float, values: Array, terms: Array, sigma: Array) -> float:
    """Return the τ at which the sum Q is as wanted, or the limit that is nearest."""
    def surplus(tau: float) -> float:
        variance = sigma**2 + tau**2
        return float(np.sum(residuals(values, terms, variance)**2 / variance)) - wanted

    if surplus(LEAST_SCATTER) <= 0:
        return LEAST_SCATTER
    if surplus(LARGEST_SCATTER) >= 0:
        return LARGEST_SCATTER
    return float(brentq(surplus, LEAST_SCATTER, LARGEST_SCATTER, rtol=1e-4))


def log_likelihood(values: Array, terms: Array, sigma: Array) -> float:
    """Return the largest log likelihood of a model whose scatter τ is free, too.

    Arguments as of ``scatter_of``.
    """
    def negative(log_tau: float) -> float:
        variance = sigma**2 + math.exp(2 * log_tau)
        squares = residuals(values, terms, variance)**2 / variance
        return 0.5 * float(np.sum(np.log(2 * np.pi * variance) + squares))

    found = minimize_scalar(negative, bounds=(math.log(LEAST_SCATTER), math.log(LARGEST_SCATTER)),
                            method='bounded', options={'xatol': 1e-3})
    return -float(found.fun)


def residuals(values: Array, terms: Array, variance: Array) -> Array:
    """Return what a model leaves of values (N,) that are weighted by their variance (N,)."""
    root = np.sqrt(variance)
    found, *_ = np.linalg.lstsq(terms / root[:, None], values / root, rcond=None)
    return np.asarray(values - terms @ found)
