"""How wide beads on ink are: by the picture where bed is beside them, else by the cloud.

Where both know the width they have to agree: the picture is the sharper one, and is believed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.filters import masked_median
from bpc_perception.core.measurement.cross_section.edges.edges import Edges
from bpc_perception.core.measurement.cross_section.on_ink.bead import Beads
from bpc_perception.core.measurement.cross_section.on_ink.below import Beneath, foot_sigma, hangs
from bpc_perception.core.measurement.cross_section.on_ink.known import (
    best_of,
    carried_along,
    Known,
    mean_of,
)
from bpc_perception.core.measurement.cross_section.sections.sections import Sections

CLIFF_SIGMA_PX = 0.25  # of a place known to a pixel, which is the same all along a straight edge
APART_PX = 0.5  # farther out than ink below reaches, an edge in the picture is that of the bead
AGREE_SIGMAS = 3.0  # within which picture and cloud agree
# By how much, as a share of the usual width, one may differ that the cloud tells in part, and one
# of which both edges are seen.
MOST_UNLIKE, MOST_UNLIKE_SEEN = 0.15, 0.25
USUAL_M, LEAST_SURE = 8e-3, 10  # so far around, so many samples tell what is usual
LEAST_TOP = 0.3  # of the usual height of a bead; what is lower is none
LARGEST_SIGMA = 0.15  # of a width that the cloud alone tells, as a share of it


@dataclass(frozen=True)
class Widths:
    """How wide N beads are; NaN = not known.

    Attributes:
        width, sigma: (N,) with its 1-sigma uncertainty [m].
        left, right: (N,) distances from the path to the edges [m].
        sure: (N,) whether it can be believed.
    """

    width: Array
    sigma: Array
    left: Array
    right: Array
    sure: Flags


def find_widths(sections: Sections, slope: Array, edges: tuple[Edges, Edges], *,
                beneath: Beneath, cliffs: tuple[Array, Array], reach: Array, edge_sigma: float,
                beads: Beads | None, depth_sigma: float) -> Widths:
    """Return what picture and cloud say together of N sections.

    Args:
        sections: N sections.
        slope: (N,) how far a place seems to be shifted to the left, per height above the foot.
        edges: in the picture, on the left and on the right.
        beneath: which ink lies under the beads.
        cliffs: (N,) where beads break off in the cloud, on both sides [m].
        reach: (2, N) how far out ink below seems to reach on both sides [m].
        edge_sigma: of an edge in the picture, beside its noise [m].
        beads: what the cloud says; None = it lies, and only the picture tells.
        depth_sigma: of how far points lay below the surface [m].
    """
    foot = np.hypot(foot_sigma(beneath), depth_sigma)
    # On ink the cloud goes down where that ends, whatever is on it.
    free = hangs(beneath) & (beads is not None)
    sides = [_side(edge, np.where(free, cliff, np.nan), out, sections, edge_sigma)
             for edge, cliff, out in zip(edges, cliffs, reach, strict=True)]
    (left, left_sigma), (right, right_sigma) = sides
    if beads is None:
        return _pictured(left, right, np.hypot(left_sigma, right_sigma), sections)
    pictured = np.all([edge.distance == place for edge, (place, _) in zip(
        edges, sides, strict=True)], axis=0)
    middle_sigma = np.hypot(beads.width_sigma / 2, slope * foot)
    by_cloud = (beads.width,
                np.hypot(beads.width_sigma, beads.width / (2 * beads.top) * foot))
    # An edge and the middle tell a width as well.
    seen = mean_of((left + right, np.hypot(left_sigma, right_sigma)),
                   (2 * (left - beads.middle), 2 * np.hypot(left_sigma, middle_sigma)),
                   (2 * (right + beads.middle), 2 * np.hypot(right_sigma, middle_sigma)))
    # Where no edge is seen, the bead goes on as before and behind, as far as the cloud agrees.
    width, sigma = found = best_of(seen, mean_of(carried_along(*seen, sections), by_cloud))
    both = np.isfinite(left + right) & (width == left + right)
    return Widths(width, sigma, np.where(both, left, beads.middle + width / 2),
                  np.where(both, right, width / 2 - beads.middle),
                  believed(found, by_cloud, beads.top, pictured, sections))


def _pictured(left: Array, right: Array, sigma: Array, sections: Sections) -> Widths:
    """Return what the picture alone tells of N sections, where it shows both edges [m]."""
    width = left + right
    sure = sigma <= LARGEST_SIGMA * width
    return Widths(width, sigma, left, right,
                  sure & like_those_around(width, sure, MOST_UNLIKE_SEEN, sections))


def believed(found: Known, by_cloud: Known, top: Array, pictured: Flags,
             sections: Sections) -> Flags:
    """Return which widths (N,) can be believed.

    Args:
        found: the widths.
        by_cloud: what the cloud alone says.
        top: (N,) heights of the beads [m].
        pictured: (N,) whether both edges are seen in the picture.
        sections: N sections.
    """
    width, sigma = found
    with np.errstate(invalid='ignore'):
        usual = np.nanmedian(top) if np.isfinite(top).any() else np.nan
        agree = np.abs(width - by_cloud[0]) <= AGREE_SIGMAS * np.hypot(sigma, by_cloud[1])
        sure = agree & (top > LEAST_TOP * usual) & (sigma <= LARGEST_SIGMA * width)
    return np.asarray(sure & like_those_around(
        width, sure, np.where(pictured, MOST_UNLIKE_SEEN, MOST_UNLIKE), sections))


def like_those_around(width: Array, sure: Flags, most: Array | float,
                      sections: Sections) -> Flags:
    """Return which widths (N,) are like those that are sure (N,) around them on the bead.

    An edge among those of ink below may be theirs: what is told has to go on along the bead.
    ``most`` is by how much one may differ, as a share of the usual width.
    """
    usual = usual_around(np.where(sure, width, np.nan), sections)
    return np.asarray(np.abs(width - usual) <= most * usual)


def usual_around(width: Array, sections: Sections) -> Array:
    """Return the median (N,) of the widths known around each on the same bead; NaN = too few."""
    reach = round(USUAL_M / sections.spacing)
    padded = [np.pad(values, reach, constant_values=np.nan)
              for values in (width, sections.piece.astype(float))]
    around, piece = (sliding_window_view(values, 2 * reach + 1) for values in padded)
    known = np.isfinite(around) & (piece == sections.piece[:, None])
    return np.where(known.sum(axis=1) >= LEAST_SURE, masked_median(around, known), np.nan)


def _side(edge: Edges, cliff: Array, reach: Array, sections: Sections,
          sigma: float) -> tuple[Array, Array]:
    """Return where (N,) beads end on one side, with its 1-sigma uncertainty (N,) [m].

    NaN = unknown. Where ink below reaches as far out (N,), the edge in the picture may be that of
    the ink below: then the place counts at which the cloud breaks off.
    """
    own = edge.distance > reach + APART_PX * sections.pixel
    return (np.where(own, edge.distance, cliff),
            np.where(own, np.hypot(edge.sigma, sigma), CLIFF_SIGMA_PX * sections.pixel))
