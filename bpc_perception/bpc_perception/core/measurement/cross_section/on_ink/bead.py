"""The section of a bead: a parabola through the points of the cloud across it.

A parabola describes the section of a laid bead as well as an arc or a cosine [Suryakumar et al.
2011; Xiong et al. 2013, of welded beads]. Points along a millimetre of path are fitted together:
the cloud is noisier than a bead is uneven.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.filters import window_sums, windows_around
from bpc_perception.core.measurement.cross_section.pooled_fit import (
    LEAST_POINTS,
    OUTLIER_SIGMAS,
    spread_of,
)
from bpc_perception.core.measurement.cross_section.sections.sections import (
    SAMPLE_STEP_PX,
    Sections,
)

POOLED_M = 7e-4  # to either side along the path
FITTED_SHARE = 0.85  # of the width; farther out points are rare, and mixed with what lies beside
ROUNDS = 2


@dataclass(frozen=True)
class Beads:
    """Parabolas across N path points; NaN where the cloud does not tell.

    Attributes:
        top: (N,) height above the feet of the sections [m].
        middle: (N,) offset of the ridge from the path, positive left [m].
        width: (N,) between the places where it comes down to the feet [m].
        top_sigma, width_sigma: (N,) 1-sigma uncertainty of them, without that of the feet [m].
    """

    top: Array
    middle: Array
    width: Array
    top_sigma: Array
    width_sigma: Array


def fit_beads(sections: Sections, middle: Array, width: Array) -> Beads:
    """Fit a parabola to the cloud across each of N path points.

    Args:
        sections: N sections.
        middle: (N,) offset of the bead's middle from the path, as far as it is known [m].
        width: (N,) of the bead, as far as it is known [m].
    """
    # If the bead is thought too wide, what lies beside it is fitted as well: so once more.
    first = _fit(sections, middle, width)
    own = sections.steady(np.stack((first.middle, first.width), axis=1))
    middle, width = np.where(np.isfinite(own), own, np.stack((middle, width), axis=1)).T
    return _fit(sections, middle, width)


def _fit(sections: Sections, middle: Array, width: Array) -> Beads:
    """Fit parabolas to the cloud inside beads with a middle and width (N,) [m]."""
    half = FITTED_SHARE * np.where(width > 0, width, np.nan) / 2
    with np.errstate(invalid='ignore', divide='ignore'):
        place = (sections.place - middle[:, None]) / half[:, None]
        fitted = (np.abs(place) <= 1) & np.isfinite(sections.height) & sections.visible
    window = windows_around(sections.piece, round(POOLED_M / sections.spacing))
    for _ in range(ROUNDS):
        normal, right = _sums(place, sections.height, fitted, window)
        coefficients = _solved(normal, right)
        residual = sections.height - np.einsum('nk,knm->nm', coefficients,
                                               np.stack((np.ones_like(place), place, place**2)))
        spread = spread_of(residual, fitted)
        kept = fitted & (np.abs(residual) <= OUTLIER_SIGMAS * spread)
        if _ < ROUNDS - 1:
            fitted = kept
    return _beads(coefficients, normal, spread, half, middle, sections)


def _beads(coefficients: Array, normal: Array, spread: float, half: Array, middle: Array,
           sections: Sections) -> Beads:
    level, slope, bend = coefficients.T
    with np.errstate(invalid='ignore', divide='ignore'):
        ridge = -slope / (2 * bend)
        top = level + slope * ridge / 2
        reach = np.sqrt(top / -bend)
    good = (bend < 0) & (top > 0) & (np.abs(ridge) < 1) & np.isfinite(reach)
    # Samples are closer than the points of the cloud.
    repeated = max(1.0, 1 / SAMPLE_STEP_PX * max(1.0, sections.pixel / sections.spacing))
    covariance = np.full((len(top), 3, 3), np.nan)
    covariance[good] = np.linalg.inv(normal[good]) * spread**2 * repeated
    of_top = np.stack((np.ones_like(top), ridge, ridge**2), axis=1)
    # width = 2 reach, reach^2 = top / -bend.
    with np.errstate(invalid='ignore', divide='ignore'):
        of_reach = (of_top - (top / bend)[:, None] * np.array((0.0, 0.0, 1.0))) / (
            2 * reach * -bend)[:, None]
    top_sigma, reach_sigma = (np.sqrt(np.einsum('ni,nij,nj->n', part, covariance, part))
                              for part in (of_top, of_reach))
    return Beads(*(np.where(good, values, np.nan) for values in (
        top, middle + ridge * half, 2 * reach * half, top_sigma, 2 * reach_sigma * half)))


def _sums(place: Array, height: Floats, fitted: Flags,
          window: tuple[Index, Index]) -> tuple[Array, Array]:
    """Return normal matrices (N, 3, 3) and right sides (N, 3) of pooled least squares."""
    x = np.where(fitted, place, 0.0)
    h = np.where(fitted, height, 0.0)
    powers = [fitted.astype(float), x, x**2]
    powers += [x * powers[2], powers[2]**2]
    moments = window_sums(np.stack([power.sum(axis=1) for power in powers], axis=1), window)
    right = window_sums(np.stack([(h * power).sum(axis=1) for power in powers[:3]], axis=1),
                        window)
    return moments[:, np.add.outer(np.arange(3), np.arange(3))], right


def _solved(normal: Array, right: Array) -> Array:
    """Return the solutions (N, 3); NaN where there are too few points, or none to either side."""
    solution = np.full(right.shape, np.nan)
    count, spread = normal[:, 0, 0], normal[:, 2, 2] / np.maximum(normal[:, 0, 0], 1)
    good = (count >= LEAST_POINTS) & (spread > 0.02)
    good[good] = np.linalg.cond(normal[good]) < 1e4
    solution[good] = np.linalg.solve(normal[good], right[good][..., None])[..., 0]
    return solution
