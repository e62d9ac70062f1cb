"""Height and area of beads above what lay there before."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import windows_around
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.cross_section.height import (
    ANY_ROUNDNESS,
    fit_shapes,
    Roundness,
    shape,
    SHAPED_M,
    Shapes,
    WILD_M,
)
from bpc_perception.core.measurement.cross_section.pooled_fit import (
    fit_without_outliers,
    UNKNOWN_M,
)
from bpc_perception.core.measurement.cross_section.sections.sections import (
    SAMPLE_STEP_PX,
    Sections,
)
from bpc_perception.core.measurement.samples import Sizes
from bpc_perception.core.measurement.side_points import SidePoints

BED_SIGMA_M = 5e-6  # of the bed beside a bead, beside the noise of the cloud
SHAPE_SIGMA = 0.02  # of an area, as a share of it: no bead has quite the shape that is fitted
UNSEEN_SIGMA_M = 5e-5  # of the bed where it is not seen
BED_ROUNDS = 2
BED_STEP = 2  # it is even: not all of its points are needed
BEND_M, BEND_SIGMA_M = 1e-3, 1.5e-5  # so far from the path a bed lies higher or lower by so much
EDGE_PX = 0.5  # so near an edge a pixel shows what lies beside as well
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
    rows = sections.a_pixel_apart
    some = sides.of(rows)
    cross = crosswise(sections, bed.normal, rows)
    level, level_sigma = bed_level(cross, sections.beside[rows][:, ::cross.step])
    shapes = shapes_between(cross, some, level_sigma, level)
    found = sizes(shapes, some, width_sigma[rows], np.zeros((len(rows), len(U))), level_sigma,
                  may_hang=False)
    # A bed that bends is higher below a bead than between its sides.
    found = replace(found, crest=found.crest + level)
    return found.at(np.interp(np.arange(len(width_sigma)), rows, np.arange(len(rows))))


@dataclass(frozen=True)
class Crosswise:
    """Points of the cloud across K path points, upright on their sections, which may slope.

    Attributes:
        place, height: (K, M) to the left of the path, and above the feet of the sections [m].
        offset: (M,) where the picture shows them, to the left of the path at their feet [m].
        pixel: length of a pixel's side on the surface [m].
        piece: (K,) number of the piece of path that each is on.
        spacing: between path points [m].
        step: they are at each so many samples of the sections.
        repeated: how often each point of the cloud is among them.
    """

    place: Array
    height: Array
    offset: Array
    pixel: float
    piece: Index
    spacing: float
    step: int
    repeated: float

    def inside(self, sides: SidePoints, chosen: Flags) -> Crosswise:
        """Return it without the points that the picture shows at or beyond the edges of beads.

        A low point beyond an edge may lie under the bead, as seen from above: the camera looks
        at it aslant. It is ink below, or bed.

        Args:
            sides: where the beads end.
            chosen: (K,) beads of which these points are left out.
        """
        inwards = EDGE_PX * self.pixel
        with np.errstate(invalid='ignore'):
            own = ((self.offset < sides.left_distance[:, None] - inwards)
                   & (self.offset > inwards - sides.right_distance[:, None]))
        return replace(self, height=np.where(own | ~chosen[:, None], self.height, np.nan))


def crosswise(sections: Sections, up: Array, rows: Index) -> Crosswise:
    """Return the points of the cloud along sections.

    Args:
        sections: N sections.
        up: (3,) or (N, 3) in which direction their heights are told.
        rows: (K,) index of sections.
    """
    step = max(1, round(1 / SAMPLE_STEP_PX))
    place = np.where(sections.visible[rows][:, ::step], sections.place[rows][:, ::step],
                     np.nan).astype(np.float64)
    slope = np.sum(sections.lateral * up, axis=1)[rows]
    spacing = sections.spacing * len(sections.piece) / max(1, len(rows))
    return Crosswise(place, sections.height[rows][:, ::step] - place * slope[:, None],
                     sections.offset[::step], sections.pixel, sections.piece[rows], spacing, step,
                     max(1.0, sections.pixel / spacing))


def bed_level(cross: Crosswise, beside: Flags) -> tuple[Array, Array]:
    """Return how high (K,) the bed lies above the feet of sections, with its sigma (K,) [m].

    The feet lie on a straight line between the bed on both sides, and the bed may bend.

    Args:
        cross: the cloud across K path points.
        beside: (K, M) where bed is to be expected.
    """
    x = cross.place[:, ::BED_STEP] / BEND_M
    height = cross.height[:, ::BED_STEP]
    fitted = beside[:, ::BED_STEP] & (np.abs(height) < WILD_M)
    basis = (np.ones_like(x), x, x**2)
    window = windows_around(cross.piece, round(SHAPED_M / cross.spacing))
    found, _ = fit_without_outliers(basis, height, fitted, window, WILD_M,
                                    (UNKNOWN_M, UNKNOWN_M, BEND_SIGMA_M), cross.repeated,
                                    BED_ROUNDS)
    level, sigma = found.values[:, 0], np.sqrt(found.covariance[:, 0, 0])
    known = sigma < UNSEEN_SIGMA_M
    return np.where(known, level, 0.0), np.where(known, np.hypot(sigma, BED_SIGMA_M),
                                                 UNSEEN_SIGMA_M)


def shapes_between(cross: Crosswise, sides: SidePoints, foot_sigma: Array,
                   foot: Array | float = 0.0,
                   round_like: Roundness = ANY_ROUNDNESS) -> Shapes:
    """Fit the cloud between the side points of K sections.

    Args:
        cross: the cloud across them.
        sides: where the beads end.
        foot_sigma: (K,) 1-sigma uncertainty of the feet of the beads [m].
        foot: (K,) how high they are above those of the sections [m].
        round_like: what is known of how round the beads are.
    """
    half = sides.width / 2
    middle = (sides.left_distance - sides.right_distance) / 2
    with np.errstate(invalid='ignore', divide='ignore'):
        u = (cross.place - middle[:, None]) / half[:, None]
    near = np.flatnonzero((np.abs(u) < 1).any(axis=0))
    return fit_shapes(u[:, near], cross.height[:, near] - np.reshape(foot, (-1, 1)), cross.piece,
                      cross.spacing, foot_sigma, cross.repeated, round_like)


def sizes(shapes: Shapes, sides: SidePoints, width_sigma: Array, before: Array,
          before_sigma: Array, may_hang: bool = True) -> Sizes:
    """Return the sizes of N beads.

    Ink that hangs over a pore counts from its own feet on: below them there is none. On a bed,
    where none hangs, feet that seem to be higher are noise.

    Args:
        shapes: the sections of the beads.
        sides: where they end.
        width_sigma: (N,) of the width between them [m].
        before: (N, K) height of the surface before above the feet of the sections, at ``U`` [m];
            -inf = far below.
        before_sigma: (N,) its 1-sigma uncertainty [m].
        may_hang: whether they may lie above the surface before.
    """
    half = sides.width / 2
    after, feet = shapes.at(U), shapes.level[:, None] if may_hang else -np.inf
    supported = before > feet
    floor = np.maximum(before, feet)
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
                             + area**2 * (SHAPE_SIGMA**2 + (width_sigma / (2 * half))**2))
    return Sizes(crest, crest_sigma, height, height_sigma, area, area_sigma)
