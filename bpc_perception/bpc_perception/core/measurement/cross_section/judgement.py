"""What is known of each sample: a measured width, a gap, or the reason why there is neither."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats
from bpc_perception.core.filters import masked_median, running_median
from bpc_perception.core.measurement.cross_section.appearance.appearance import Appearance, UNTOLD
from bpc_perception.core.measurement.cross_section.edges.edges import Edges
from bpc_perception.core.measurement.cross_section.passes import (
    meets_other_pass,
    reaches_other_part,
    turns_back,
)
from bpc_perception.core.measurement.cross_section.sections.lines import (
    colours_at,
    Lines,
    pixels_along,
)
from bpc_perception.core.measurement.cross_section.sections.sections import (
    SAMPLE_STEP_PX,
    Sections,
)
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.measurement.view import View
from bpc_perception.core.profile import Cause, CauseArray, Status

HALF = 0.5  # share of ink at an edge
# A share this near to half is the end of a run of ink: it is neither ink nor bed.
UNSURE = 0.1
USUAL_WIDTH = 0.15  # share of a width by which it may differ from those around under glare
TYPICAL_HALF_LENGTH_M = 0.005  # of path over which the width to be expected is taken
SIXTH = 6.0  # the middle third of a bead reaches a sixth of its width to either side
# In these sixths: how far to either side a gap must be bare, 0.4 of a width, and from which length
# on ink within that is no gap.
GAP_REACH = 2.4
GAP_INK = 0.5
ACROSS_PX = np.arange(-2.0, 3.0)  # beside the path, where the end of a run is looked for
LEAST_LEAN = 0.1  # of a pixel, that a ridge has to be shifted to hide anything


@dataclass(frozen=True)
class Middle:
    """What is seen where the bead is to be expected, around the path.

    Attributes:
        inked: (N,) whether there is ink in the middle third.
        glary: (N,) whether glare hides all of it.
        bare: (N,) whether there is bed in it, and no ink within 0.4 of the width.
    """

    inked: Flags
    glary: Flags
    bare: Flags


def judge(sections: Sections, ink: Floats, left: Edges, right: Edges, untold: CauseArray,
          faint: Flags, ending: Flags) -> Verdicts:
    """Return what is known of each sample.

    Args:
        sections: N sections with M samples each.
        ink: (N, M) share of ink in each sample, NaN = not seen.
        left: edges on the left.
        right: edges on the right.
        untold: (N,) why ink is not told from bed; NONE = it is.
        faint: (N,) whether there is so much noise that an edge may be lost in it.
        ending: (N,) whether ink begins or ends within half a pixel along the path.
    """
    width = left.distance + right.distance
    typical = typical_width(width, sections)
    middle = look_at_middle(sections, ink, typical)
    # No spot of glare on the bed is as wide as the bead.
    usual = np.abs(width - typical) <= USUAL_WIDTH * typical
    inked, gap = middle.inked | (middle.glary & usual), middle.bare & ~sections.raised
    crossing = (meets_other_pass(sections, typical, inked) | left.joined | right.joined
                | reaches_other_part(sections, left.distance, right.distance, typical)
                | turns_back(sections, typical))
    on_path = sections.on_path
    told = untold == Cause.NONE
    shining = inked & (np.isnan(ink) & sections.visible).any(axis=1)
    return Verdicts.by_first((
        (sections.hidden[:, on_path], Status.OCCLUDED, Cause.NONE),
        (~sections.inside[:, on_path], Status.NO_DATA, Cause.OUTSIDE_IMAGE),
        (~sections.depth, Status.NO_DATA, Cause.NO_DEPTH),
        (inked & crossing, Status.JUNCTION, Cause.NONE),
        *((untold == cause, Status.LOW_CONFIDENCE, cause) for cause in UNTOLD),
        (inked & (left.hidden | right.hidden), Status.OCCLUDED, Cause.NONE),
        (inked & (left.outside | right.outside), Status.NO_DATA, Cause.OUTSIDE_IMAGE),
        (ending, Status.LOW_CONFIDENCE, Cause.INK_ENDS),
        (inked & leans_over_gap(sections, gap & told), Status.LOW_CONFIDENCE, Cause.INK_ENDS),
        (gap, Status.GAP, Cause.NONE),
        (inked & np.isfinite(width), Status.MEASURED, Cause.NONE),
        (shining | middle.glary, Status.LOW_CONFIDENCE, Cause.GLARE),
        (inked & faint, Status.LOW_CONFIDENCE, Cause.FAINT_EDGES),
        (inked, Status.LOW_CONFIDENCE, Cause.NO_EDGE),
        (middle.bare, Status.LOW_CONFIDENCE, Cause.RAISED)),
        Verdicts.all_of(len(width), Status.LOW_CONFIDENCE, Cause.PARTLY_INK))


def typical_width(width: Array, sections: Sections) -> Array:
    """Return the width (N,) to be expected, from widths (N,) around along the path [m]."""
    return running_median(width, 2 * round(TYPICAL_HALF_LENGTH_M / sections.spacing) + 1,
                          sections.piece)


def look_at_middle(sections: Sections, ink: Floats, typical: Array) -> Middle:
    """Look for ink in the middle third of a bead of typical width (N,) [m].

    Not on the path alone: a spot of glare there does no harm. Where no width is to be expected, or
    it is less than six pixels, a pixel to either side is looked at.
    """
    reach = np.fmax(typical / SIXTH, sections.pixel)[:, None]
    offset = np.abs(sections.offset)
    near = offset <= GAP_REACH * reach.max()
    offset, share = offset[near], ink[:, near]
    centre = masked_median(share, (offset <= reach) & np.isfinite(share))
    inky = (offset <= GAP_REACH * reach) & (share > HALF + UNSURE)
    ink_length = np.count_nonzero(inky, axis=1) * SAMPLE_STEP_PX * sections.pixel
    return Middle(inked=centre >= HALF + UNSURE, glary=np.isnan(centre),
                  bare=(np.abs(centre) <= HALF - UNSURE) & (ink_length < reach[:, 0] * GAP_INK))


def ends_within_pixel(view: View, sections: Sections, appearance: Appearance,
                      normal: Array) -> Flags:
    """Return where (N,) ink begins or ends within half a pixel along the path, before or behind.

    No image can say whether there is ink at such a sample itself.
    """
    step = sections.pixel / 2 * np.cross(sections.lateral, normal)
    lines = Lines(np.concatenate((sections.foot - step, sections.foot + step)),
                  np.tile(sections.lateral, (2, 1)), ACROSS_PX * sections.pixel)
    colour = colours_at(view, pixels_along(view, lines))
    from_bed = colour.reshape(2, len(step), -1, 3) - appearance.bed.mean(axis=0)[:, None]
    share = np.sort(np.einsum('bnmk,nk->bnm', from_bed, appearance.weight), axis=2)
    before, behind = share[..., len(ACROSS_PX) // 2] > HALF
    return np.asarray(before != behind)


def leans_over_gap(sections: Sections, gap: Flags) -> Flags:
    """Return where (N,) what looks like ink may be the end of a bead that hides a gap behind it.

    Seen obliquely along the path, the ridge of a bead's end covers the bed beyond.
    """
    arc = sections.along
    gaps = arc[gap]
    if len(gaps) == 0:
        return np.zeros(len(gap), bool)
    after = np.searchsorted(gaps, arc)
    padded = np.concatenate(([-np.inf], gaps, [np.inf]))
    ahead, behind = padded[after + 1] - arc, arc - padded[after]
    reach = np.abs(sections.lean) + sections.spacing / 2
    leaning = np.abs(sections.lean) > LEAST_LEAN * sections.pixel
    return np.asarray(leaning & (np.where(sections.lean > 0, ahead, behind) < reach))
