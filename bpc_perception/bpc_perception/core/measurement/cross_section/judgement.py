"""What is known of each sample of the sections."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.filters import masked_median, running_median
from bpc_perception.core.geometry import invert
from bpc_perception.core.measurement.cross_section.appearance import (
    Light,
)
from bpc_perception.core.measurement.cross_section.edges import Edges
from bpc_perception.core.measurement.cross_section.passes import meets_itself
from bpc_perception.core.measurement.cross_section.sampling import (
    project,
    sample_image,
)
from bpc_perception.core.measurement.cross_section.sections import Sections, STEP
from bpc_perception.core.profile import Status, StatusArray

ACROSS = np.arange(-2.0, 3.0)  # where ink is looked for beside the path [pixels]
RIM = 0.1  # a centre this near to half ink is the end of a run, and not judged


def judge(sections: Sections, ink: Floats, left: Edges, right: Edges,
          noisy: Flags) -> StatusArray:
    """What is known of each sample (N,), from its share of ink (N, M) and its edges."""
    width = left.distance + right.distance
    # Of the middle third, so that a spot of glare on the path does no harm.
    typical = running_median(width, 2 * round(0.005 / sections.spacing) + 1)
    reach = np.fmax(typical / 6, sections.pixel)[:, None]
    offset = np.abs(sections.offset)
    middle = offset <= 2.4 * reach.max()
    offset, around = offset[middle], ink[:, middle]
    centre = masked_median(around, (offset <= reach) & np.isfinite(around))
    status = np.full(len(width), Status.LOW_CONFIDENCE, np.uint8)
    status[(centre >= 0.5 + RIM) & np.isfinite(width)] = Status.MEASURED
    inky = np.count_nonzero((offset <= 2.4 * reach) & (around > 0.5 + RIM), axis=1)
    bare = inky * STEP * sections.pixel < reach[:, 0] / 2
    status[(np.abs(centre) <= 0.5 - RIM) & bare & ~sections.raised] = Status.GAP
    inked = centre >= 0.5 + RIM
    status[inked & (left.outside | right.outside)] = Status.NO_DATA
    status[inked & (left.hidden | right.hidden)] = Status.OCCLUDED
    status[noisy] = Status.LOW_CONFIDENCE
    status[(status == Status.MEASURED) & leans_over_gap(sections, status)] = Status.LOW_CONFIDENCE
    crossing = meets_itself(sections, typical, inked) | left.joined | right.joined
    status[crossing & inked] = Status.JUNCTION
    on_path = len(sections.offset) // 2
    status[~sections.inside[:, on_path] | ~sections.depth] = Status.NO_DATA
    status[sections.hidden[:, on_path]] = Status.OCCLUDED
    return status


def ends_within_pixel(capture: Capture, sections: Sections, light: Light, T_base_camera: Array,
                      normal: Array) -> Flags:
    """Where (N,) ink begins or ends within half a pixel along the path, before or behind.

    Whether there is ink at such a sample itself, no image can tell.
    """
    step = sections.pixel / 2 * np.cross(sections.lateral, normal)
    places = np.concatenate((sections.foot - step, sections.foot + step))
    uv = project(capture, places, np.tile(sections.lateral, (2, 1)), ACROSS * sections.pixel,
                 invert(T_base_camera))
    colour = sample_image(capture.image, uv).reshape(2, len(step), -1, 3)
    colour = colour - light.bed.mean(axis=0)[:, None]
    share = np.sort(np.einsum('bnmk,nk->bnm', colour, light.weight), axis=2)
    before, behind = share[..., len(ACROSS) // 2] > 0.5
    return np.asarray(before != behind)


def leans_over_gap(sections: Sections, status: StatusArray) -> Flags:
    """Where (N,) what looks like ink may be the end of a bead that hides a gap behind it.

    Seen obliquely along the path, the ridge of a bead's end covers the bed beyond.
    """
    arc = sections.index * sections.spacing
    gaps = arc[status == Status.GAP]
    if len(gaps) == 0:
        return np.zeros(len(status), bool)
    after = np.searchsorted(gaps, arc)
    padded = np.concatenate(([-np.inf], gaps, [np.inf]))
    ahead, behind = padded[after + 1] - arc, arc - padded[after]
    reach = np.abs(sections.lean) + sections.spacing / 2
    leaning = np.abs(sections.lean) > RIM * sections.pixel
    return np.asarray(leaning & (np.where(sections.lean > 0, ahead, behind) < reach))
