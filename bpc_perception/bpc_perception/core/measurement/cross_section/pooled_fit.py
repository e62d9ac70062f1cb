"""Least squares along a path: points of neighbouring sections are fitted together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import window_sums

LEAST_POINTS = 12
OUTLIER_SIGMAS = 3.0
LEAST_INDEPENDENT = 1e-10  # that can be solved; less is rounding
UNKNOWN_M = 1.0  # 1-sigma of what nothing is known of beforehand


def spread_of(residual: Array, fitted: Flags) -> float:
    """Return the standard deviation of what was fitted, whatever outliers are among it."""
    known = fitted & np.isfinite(residual)
    return 1.4826 * float(np.median(np.abs(residual[known]))) if known.any() else np.nan


@dataclass(frozen=True)
class PooledFit:
    """Coefficients (N, K) of N fits, and their covariance (N, K, K); NaN = too few points."""

    values: Array
    covariance: Array

    def residual(self, basis: tuple[Array, ...], height: Array) -> Array:
        """Return how far heights (N, M) lie above the fits."""
        return np.asarray(height - sum(part * value[:, None] for part, value in zip(
            basis, self.values.T, strict=True)))


def fit_without_outliers(basis: tuple[Array, ...], height: Array, fitted: Flags,
                         window: tuple[Index, Index], noise: float,
                         sigmas: tuple[Array | float, ...], repeated: float,
                         rounds: int) -> tuple[PooledFit, Flags]:
    """Fit as ``pooled_fit``, and again without the points that lie far off.

    ``noise`` is that of the first round, ``repeated`` how often each point is among those given.

    Returns:
        The last fit, and which points (N, M) it was made from.
    """
    fit = pooled_fit(basis, height, fitted, window, noise, sigmas)
    for _ in range(rounds - 1):
        fitted, noise = without_outliers(fit.residual(basis, height), fitted, repeated)
        fit = pooled_fit(basis, height, fitted, window, noise, sigmas)
    return fit, fitted


def without_outliers(residual: Array, fitted: Flags, repeated: float) -> tuple[Flags, float]:
    """Return which of the fitted points (N, M) are no outliers, and the 1-sigma noise of a point.

    ``residual`` (N, M) is how far they lie above their fits, ``repeated`` how often each is among
    those given.
    """
    spread = spread_of(residual, fitted)
    return (fitted & (np.abs(residual) <= OUTLIER_SIGMAS * spread),
            spread * float(np.sqrt(repeated)))


def pooled_fit(basis: tuple[Array, ...], height: Array, fitted: Flags,
               window: tuple[Index, Index], noise: float,
               sigmas: tuple[Array | float, ...]) -> PooledFit:
    """Fit heights (N, M) by sums of a basis of K functions (N, M), of rows in a window together.

    Args:
        basis: the functions.
        height: of the points.
        fitted: (N, M) which of them count.
        window: first row of each, and that behind its last.
        noise: 1-sigma of a point [m].
        sigmas: (N,) or one for all, how far each coefficient may be from 0, as known beforehand.
    """
    parts = [np.where(fitted, part, 0.0) for part in basis]
    high = np.where(fitted, height, 0.0)
    count = len(parts)
    products = [np.einsum('nm,nm->n', parts[i], other) for i in range(count)
                for other in (*parts[i:], high)]
    sums = iter(window_sums(np.array((*products, fitted.sum(axis=1))).T, window).T)
    normal, right = np.empty((len(height), count, count)), np.empty((len(height), count))
    for i in range(count):
        for j in range(i, count):
            normal[:, i, j] = normal[:, j, i] = next(sums)
        right[:, i] = next(sums)
    enough = (next(sums) >= LEAST_POINTS) & np.isfinite(noise)
    for i, sigma in enumerate(sigmas):
        with np.errstate(divide='ignore'):
            normal[:, i, i] += (noise / np.asarray(sigma)) ** 2
    enough &= np.isfinite(normal).all(axis=(1, 2))
    # Hadamard's inequality: 1 if the functions are independent there, 0 if they are the same.
    largest = np.diagonal(normal[enough], axis1=1, axis2=2).prod(axis=1)
    with np.errstate(invalid='ignore', divide='ignore'):
        independent = np.linalg.det(normal[enough]) / largest
    enough[enough] = independent > LEAST_INDEPENDENT
    values, covariance = np.full(right.shape, np.nan), np.full(normal.shape, np.nan)
    inverse = np.linalg.inv(normal[enough])
    values[enough] = np.einsum('nij,nj->ni', inverse, right[enough])
    covariance[enough] = inverse * noise**2
    return PooledFit(values, covariance)
