"""Height and area of beads above what lay there before."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.filters import windows_around
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.cross_section.height import (
    fit_shapes,
    OUTLIER_SIGMAS,
    shape,
    SHAPED_M,
    Shapes,
    WILD_M,
)
from bpc_perception.core.measurement.cross_section.pooled_fit import (
    pooled_fit,
    spread_of,
    UNKNOWN_M,
)
from bpc_perception.core.measurement.cross_section.sections.sections import (
    SAMPLE_STEP_PX,
    Sections,
)
from bpc_perception.core.measurement.samples import Sizes
from bpc_perception.core.measurement.side_points import SidePoints

BED_SIGMA_M = 5e-6  # of the bed beside a bead, beside the noise of the cloud
UNSEEN_SIGMA_M = 5e-5  # of the bed where it is not seen
BEND_M, BEND_SIGMA_M = 1e-3, 1.5e-5  # so far from the path a bed lies higher or lower by so much
# Across a bead, from edge to edge: places, and their weights in a sum over the section.
U, WEIGHT = np.polynomial.legendre.leggauss(15)
MIDDLE = len(U) // 2


def sizes_on_bed(sections: Sections, sides: SidePoints, width_sigma: Array, bed: Plane) -> Sizes:
    """Return the sizes of N beads that lie on the bed.

    Args:
        sections: N sections.
        sides: where the beads end.
        width_sigma: (N,) of the width between them [m].
        bed: plane of the bed.
    """
    level, level_sigma = bed_level(sections, bed.normal)
    shapes = shapes_between(sections, sides, bed.normal, level_sigma, level)
    return sizes(shapes, sides, width_sigma, np.zeros((len(level), len(U))),
                 np.zeros(len(level)))


def bed_level(sections: Sections, up: Array) -> tuple[Array, Array]:
    """Return how high (N,) the bed lies above the feet of sections, with its sigma (N,) [m].

    The feet lie on a straight line between the bed on both sides, and the bed may bend.
    """
    place, height = upright(sections, up, np.ones(len(sections.offset), bool))
    x = place / BEND_M
    fitted = sections.beside & (np.abs(height) < WILD_M)
    basis = (np.ones_like(x), x, x**2)
    window = windows_around(sections.piece, round(SHAPED_M / sections.spacing))
    noise = WILD_M
    for _ in range(2):
        found = pooled_fit(basis, height, fitted, window, noise,
                           (UNKNOWN_M, UNKNOWN_M, BEND_SIGMA_M))
        residual = found.residual(basis, height)
        spread = spread_of(residual, fitted)
        noise = spread * np.sqrt(repeated(sections))
        fitted &= np.abs(residual) <= OUTLIER_SIGMAS * spread
    level, sigma = found.values[:, 0], np.sqrt(found.covariance[:, 0, 0])
    known = sigma < UNSEEN_SIGMA_M
    return np.where(known, level, 0.0), np.where(known, np.hypot(sigma, BED_SIGMA_M),
                                                 UNSEEN_SIGMA_M)


def shapes_between(sections: Sections, sides: SidePoints, up: Array, foot_sigma: Array,
                   foot: Array | float = 0.0) -> Shapes:
    """Fit the cloud between the side points of N sections.

    Args:
        sections: N sections.
        sides: where the beads end.
        up: (3,) or (N, 3) in which direction the heights of the sections are told.
        foot: (N,) how high the feet of the beads are above those of the sections [m].
        foot_sigma: (N,) 1-sigma uncertainty of that [m].
    """
    half = (sides.left_distance + sides.right_distance) / 2
    middle = (sides.left_distance - sides.right_distance) / 2
    near = np.abs(sections.offset) <= np.nanmax(np.abs(middle) + half, initial=0.0)
    place, height = upright(sections, up, near)
    height -= np.reshape(foot, (-1, 1))
    with np.errstate(invalid='ignore', divide='ignore'):
        u = (place - middle[:, None]) / half[:, None]
    return fit_shapes(u, height, sections.piece, sections.spacing, foot_sigma,
                      repeated(sections))


def upright(sections: Sections, up: Array, chosen: Flags) -> tuple[Array, Array]:
    """Return places and heights of samples (N, K), upright on their sections, which may slope.

    Args:
        sections: N sections.
        up: (3,) or (N, 3) in which direction their heights are told.
        chosen: (M,) K of their samples.
    """
    place = np.where(sections.visible[:, chosen], sections.place[:, chosen],
                     np.nan).astype(np.float64)
    slope = np.sum(sections.lateral * up, axis=1)
    return place, sections.height[:, chosen] - place * slope[:, None]


def repeated(sections: Sections) -> float:
    """Return how often each point of the cloud is among the samples of sections."""
    return max(1.0, 1 / SAMPLE_STEP_PX) * max(1.0, sections.pixel / sections.spacing)


def sizes(shapes: Shapes, sides: SidePoints, width_sigma: Array, before: Array,
          before_sigma: Array) -> Sizes:
    """Return the sizes of N beads.

    Ink that hangs over a pore counts from its own feet on: below them there is none.

    Args:
        shapes: the sections of the beads.
        sides: where they end.
        width_sigma: (N,) of the width between them [m].
        before: (N, K) height of the surface before above the feet of the sections, at ``U`` [m];
            -inf = far below.
        before_sigma: (N,) its 1-sigma uncertainty [m].
    """
    half = (sides.left_distance + sides.right_distance) / 2
    after, level = shapes.at(U), shapes.level[:, None]
    supported = before > level
    floor = np.maximum(before, level)
    above = after - floor
    inked = (above > 0) * WEIGHT
    area = half * (above * inked).sum(axis=1)
    rise = shape(U, shapes.roundness[:, None])
    of_level, of_rise = half * (supported * inked).sum(axis=1), half * (rise * inked).sum(axis=1)
    crest, crest_sigma = shapes.crest
    resting = supported[:, MIDDLE]
    height = crest - floor[:, MIDDLE]
    height_sigma = np.hypot(np.where(resting, crest_sigma, shapes.sigma_of(
        np.zeros(len(half)), np.ones(len(half)))), np.where(resting, before_sigma, 0.0))
    with np.errstate(invalid='ignore', divide='ignore'):
        area_sigma = np.sqrt(shapes.sigma_of(of_level, of_rise)**2
                             + (of_level * before_sigma)**2
                             + (area * width_sigma / (2 * half))**2)
    return Sizes(crest, crest_sigma, height, height_sigma, area, area_sigma)
