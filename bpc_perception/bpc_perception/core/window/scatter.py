"""How much lines differ from each other beyond what their uncertainties tell."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from statsmodels.regression.linear_model import WLS

from bpc_perception.core.arrays import Array

LEAST_SCATTER = 1e-4  # of a line against others: none is laid more evenly [share]
LARGEST_SCATTER = 1.0


def scatter_of(values: Array, terms: Array, sigma: Array) -> float:
    """Return the standard deviation τ from line to line, after Paule and Mandel (1982).

    It is the one with which Σ r² / (σ² + τ²) equals the degrees of freedom.

    Args:
        values: (N,) logarithms that a model explains.
        terms: (N, P) of the model.
        sigma: (N,) own uncertainty of each value.
    """
    free = len(values) - terms.shape[1]

    def surplus(tau: float) -> float:
        weights = 1 / (sigma**2 + tau**2)
        residual = WLS(values, terms, weights=weights).fit().resid
        return float(np.sum(weights * residual**2)) - free

    if surplus(LEAST_SCATTER) <= 0:
        return LEAST_SCATTER
    if surplus(LARGEST_SCATTER) >= 0:
        return LARGEST_SCATTER
    return float(brentq(surplus, LEAST_SCATTER, LARGEST_SCATTER, xtol=1e-7))


def log_likelihood(values: Array, terms: Array, sigma: Array) -> float:
    """Return the largest log likelihood of a model whose scatter τ is free, too.

    Arguments as of ``scatter_of``.
    """
    def negative(log_tau: float) -> float:
        variance = sigma**2 + math.exp(2 * log_tau)
        residual = WLS(values, terms, weights=1 / variance).fit().resid
        return 0.5 * float(np.sum(np.log(2 * np.pi * variance) + residual**2 / variance))

    found = minimize_scalar(negative, bounds=(math.log(LEAST_SCATTER), math.log(LARGEST_SCATTER)),
                            method='bounded', options={'xatol': 1e-3})
    return -float(found.fun)
