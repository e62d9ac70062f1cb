"""What picture and cloud tell together: each as far as it is sure, and never against the other.

Ink that hardly differs from its bed, a reflection, lines printed on the bed: there the picture has
no edge, or a wrong one, and the cloud tells alone. Where both tell, and differ by more than they
can, neither is believed. A picture that is of no use in most of the print is not asked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.measurement.cross_section.by_cloud.cloud_beads import (
    BeadModel,
    CloudBeads,
    find_cloud_beads,
    Lines,
)
from bpc_perception.core.measurement.cross_section.edges.edges import Edges
from bpc_perception.core.measurement.cross_section.passes import meets_other_pass
from bpc_perception.core.measurement.cross_section.sections.sections import Sections
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.profile import Cause, Status

# Why a picture does not tell; and besides, where it is of no use in most of the print.
UNTOLD = (Cause.GLARE, Cause.LOW_CONTRAST, Cause.OLD_INK, Cause.NO_EDGE, Cause.FAINT_EDGES,
          Cause.UNSURE_FEET)
HARDLY_TOLD = *UNTOLD, Cause.PARTLY_INK, Cause.INK_ENDS, Cause.FEW_PIXELS
LEAST_TOLD = 0.5  # share of the samples that a picture of use tells
MOST_UNEVEN = 0.05  # of a width, by which it then differs from those around,
MOST_WIDER = 0.15  # and from what the cloud tells
# From so many sigmas, and this share of a width, picture and cloud contradict each other.
CONTRADICTION, CONTRADICTION_SHARE = 4.0, 0.15
LIKELY_TOP, MOST_UNLIKE = (0.6, 1.6), 0.25  # of what is usual, of a bead that the cloud shows


@dataclass(frozen=True)
class Told:
    """Edges of N beads as one source tells them; NaN = it does not.

    Attributes:
        left, right: (N,) distances from the path [m].
        sigma: (N,) 1-sigma uncertainty of the width between them [m],
        common: (N,) and of what is wrong with it all along the print [m].
        compared: whether (N,) it is that of picture and cloud compared; one or for all.
    """

    left: Array
    right: Array
    sigma: Array
    common: Array
    compared: Flags | bool = True

    @property
    def width(self) -> Array:
        """(N,) [m]."""
        return self.left + self.right

    @property
    def total(self) -> Array:
        """(N,) sigma with all of its parts [m]."""
        return np.hypot(self.sigma, self.common)


def lines_in_picture(sections: Sections, left: Edges, right: Edges,
                     verdicts: Verdicts) -> Lines | None:
    """Return where N beads are in the picture; None = it is of no use in most of the print."""
    told = verdicts.status == Status.MEASURED
    asked = told | np.isin(verdicts.cause, HARDLY_TOLD)
    if not told.any() or told.sum() < LEAST_TOLD * asked.sum():
        return None
    width = np.where(told, left.distance + right.distance, np.nan)
    usual = sections.steady(width)
    if np.nanmedian(np.abs(width / usual - 1)) > MOST_UNEVEN:
        return None
    return Lines(np.where(told, (left.distance - right.distance) / 2, np.nan), width / 2)


def ask_cloud(sections: Sections, lean: Array, lines: Lines | None,
              known: BeadModel | None) -> tuple[CloudBeads, BeadModel | None, bool]:
    """Return beads in the cloud, what they look like, and whether the picture is of use.

    Args:
        sections: N sections.
        lean: (N,) see ``edges.feet.lean_to_left``.
        lines: where beads are in the picture; None = it is of no use.
        known: what beads of the whole print look like; None = these sections tell it.
    """
    beads, model = find_cloud_beads(sections, lean, lines, known)
    if lines is None or model is None:
        return beads, model, lines is not None
    wider = beads.width / (2 * lines.half)
    compared = np.isfinite(wider)
    if not compared.any() or abs(np.median(wider[compared]) - 1) <= MOST_WIDER:
        return beads, model, True
    return *find_cloud_beads(sections, lean, None, known), False


def told_by_both(picture: Told, cloud: Told, beads: CloudBeads, verdicts: Verdicts,
                 sections: Sections, maximum_sigma: float,
                 picture_of_use: bool) -> tuple[Told, Verdicts]:
    """Return what picture and cloud tell together of N sections.

    Args:
        picture: what it tells,
        cloud: and what the cloud tells.
        beads: in the cloud.
        verdicts: what the picture says of each section.
        sections: N sections.
        maximum_sigma: of a width, as a share of it, above which it is not told.
        picture_of_use: whether the picture tells most of the print.
    """
    measured = verdicts.status == Status.MEASURED
    shows = shows_bead(beads, sections) & (cloud.total <= maximum_sigma * cloud.width)
    if picture_of_use:
        alone = shows & np.isin(verdicts.cause, UNTOLD)
        refused = measured & shows & contradict(picture, cloud)
    else:
        alone = shows & (measured | np.isin(verdicts.cause, HARDLY_TOLD))
        refused = measured & ~shows & np.isfinite(cloud.width).any()
    told = weighed(picture, cloud, measured & shows & cloud.compared & ~refused, alone)
    crossing = meets_other_pass(sections, told.width, alone)
    return told, Verdicts.by_first(
        [(alone & crossing, Status.JUNCTION, Cause.NONE),
         (alone, Status.MEASURED, Cause.NONE),
         (refused, Status.LOW_CONFIDENCE, Cause.UNSURE_FEET)], verdicts)


def weighed(picture: Told, cloud: Told, both: Flags, alone: Flags) -> Told:
    """Return what is told by both (N,), each as far as it is sure; or by the cloud alone (N,).

    Elsewhere it is what the picture tells.
    """
    own, other = picture.sigma**2, cloud.sigma**2
    with np.errstate(invalid='ignore'):
        share = np.where(alone, 1.0, np.where(both, own / (own + other), 0.0))
    left, right = (np.where(share > 0, share * there + (1 - share) * np.nan_to_num(here), here)
                   for here, there in ((picture.left, cloud.left), (picture.right, cloud.right)))
    return Told(left, right, np.where(share > 0, np.sqrt(share * other), picture.sigma),
                np.where(alone, cloud.common, picture.common))


def contradict(one: Told, other: Told) -> Flags:
    """Return where (N,) two tell widths that cannot both be right."""
    limit = np.maximum(CONTRADICTION * np.hypot(one.sigma, other.sigma),
                       CONTRADICTION_SHARE * other.width)
    return np.asarray(np.abs(one.width - other.width) > limit)


def shows_bead(beads: CloudBeads, sections: Sections) -> Flags:
    """Return where (N,) the cloud shows a bead on its path, which goes on along it."""
    usual, (least, most) = sections.steady(beads.width), LIKELY_TOP
    return np.asarray((beads.left > 0) & (beads.right > 0)
                      & (beads.top > least) & (beads.top < most)
                      & (np.abs(beads.width - usual) <= MOST_UNLIKE * usual))
