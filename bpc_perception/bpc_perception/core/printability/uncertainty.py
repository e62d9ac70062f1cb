"""How the uncertainties of single widths add up.

What is wrong with a width is in part alike along a whole print, as the blur of its edges is, in
part along a stroke, by where it lies and which way it runs, and in part along a stretch of it.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from bpc_perception.core.amounts import STEADY_M
from bpc_perception.core.arrays import Array, Index

# Shares of the variance of a width, as simulated prints in layers show them.
OF_PRINT, OF_STROKE, OF_STRETCH = 0.5, 0.4, 0.1
DRAWS = 20  # of errors, by chance
SEED = 1


def sigma_of_mean(sigma: Array, length: float, strokes: int) -> float:
    """Return the 1-sigma uncertainty of a mean width.

    Args:
        sigma: (N,) of the widths [m]; one at least.
        length: of path along which they lie [m].
        strokes: in how many.
    """
    share = OF_PRINT + OF_STROKE / strokes + OF_STRETCH / independent(length)
    return float(np.mean(sigma) * np.sqrt(share))


def independent(length: float) -> float:
    """Return how many stretches there are along a length [m], 1 or more."""
    return max(length / STEADY_M, 1.0)


def draw_side_errors(sigma: Array, stroke: Index, spacing: float) -> Array:
    """Return errors of both sides of N samples by chance, the same each time.

    Args:
        sigma: (N,) 1-sigma uncertainty of the widths [m].
        stroke: (N,) number of the stroke.
        spacing: of the samples along the path [m].

    Returns:
        (DRAWS, 2, N) how far left and right lie too far out [m]. Both together have sigma.
    """
    chance = np.random.default_rng(SEED)
    own = np.unique(stroke, return_inverse=True)[1]
    of_print = _standard(chance.normal(size=(DRAWS, 1, 1))) / np.sqrt(2)
    of_stroke = _standard(chance.normal(size=(DRAWS, 2, own.max() + 1)))[..., own]
    of_stretch = _standard(gaussian_filter1d(chance.normal(size=(DRAWS, 2, len(sigma))),
                                             STEADY_M / 2 / spacing, axis=-1, mode='wrap'))
    alike = (np.sqrt(OF_PRINT) * of_print + np.sqrt(OF_STROKE) * of_stroke
             + np.sqrt(OF_STRETCH) * of_stretch)
    return np.asarray(alike * sigma / np.sqrt(2))


def _standard(drawn: Array) -> Array:
    """Return numbers by chance with a mean of 0 and a standard deviation of 1: there are few."""
    return np.asarray((drawn - drawn.mean()) / max(float(drawn.std()), np.finfo(float).tiny))
