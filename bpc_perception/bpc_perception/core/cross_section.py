"""Thickness from the image across the path: the default method.

The image is read along a line across each path point. Where it passes half-way from ink to what
lies beside it, there is the edge, to a fraction of a pixel. Which edge is meant the path says: the
first on either side, going outwards from it. What ink and bed look like is taken from the
image itself, near each point: ink lies along the path, bed far from all of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.capture import Capture
from bpc_perception.core.config import CrossSectionConfig, ThicknessConfig
from bpc_perception.core.edges import Edges, find_edges
from bpc_perception.core.geometry import Array, invert, Plane
from bpc_perception.core.light import Contrast, find_light, ink_share, Light
from bpc_perception.core.profile import Status, StatusArray
from bpc_perception.core.sections import (
    Flags,
    Floats,
    Index,
    lay_sections,
    masked_median,
    project,
    running_median,
    sample_image,
    Sections,
    STEP,
    step_within_window,
)
from bpc_perception.core.thickness import SidePoints

ACROSS = np.arange(-2.0, 3.0)  # where ink is looked for beside the path [pixels]
RIM = 0.1  # a centre this near to half ink is the end of a run, and not judged


@dataclass(frozen=True)
class CrossSections:
    """What is known of N path points.

    Attributes:
        sides: their side points.
        status: (N,) values of Status.
        sigma: (N,) 1-sigma uncertainty of the width between them [m].
        contrast: of ink and bed in all of the print; None = nothing is told apart.
    """

    sides: SidePoints
    status: StatusArray
    sigma: Array
    contrast: Contrast | None


def measure_cross_sections(
    capture: Capture, points: Array, extruding: Flags, T_base_camera: Array, bed: Plane,
    config: ThicknessConfig, index: Index | None = None, known: Contrast | None = None,
) -> CrossSections:
    """Measure a path (P, 3), or only its points of an ``index`` (N,); see ``measure``.

    Of a part alone, its ends are not known well, and the contrast of the whole print has to be.
    """
    index = np.arange(len(points)) if index is None else index
    sections = lay_sections(capture, points, index, T_base_camera, bed, config)
    # Light changes slowly along the path.
    step = step_within_window(sections.spacing)
    near = np.minimum((np.arange(len(index)) + step // 2) // step, (len(index) - 1) // step)
    light = find_light(sections.every(step), extruding[index][::step], known).at(near)
    ink = ink_share(sections, light)
    right, left = find_edges(sections, light.noise, ink)
    status = judge(sections, ink, left, right, light.noise > config.cross_section.maximum_noise)
    status[ends_within_pixel(capture, sections, light, T_base_camera, bed.normal)
           & ((status == Status.MEASURED) | (status == Status.GAP))] = Status.LOW_CONFIDENCE
    sigma = width_sigma(left, right, sections.pixel, config.cross_section)
    sides = SidePoints(sections.foot + left.distance[:, None] * sections.lateral,
                       sections.foot - right.distance[:, None] * sections.lateral,
                       left.distance, right.distance)
    return CrossSections(sides, status, sigma, light.contrast)


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


def width_sigma(left: Edges, right: Edges, pixel: float, config: CrossSectionConfig) -> Array:
    """1-sigma uncertainty (N,) of the width between two edges [m].

    The noise of both edges; what sampling leaves; and the light on the bead, which shades its
    edges and shines on its ridge: the fewer pixels the bead has, the less of that is seen apart.
    """
    noise = config.noise_gain * np.hypot(left.sigma, right.sigma)
    width = left.distance + right.distance
    narrow = config.light_sigma * (10 * pixel / width) ** 2
    return np.sqrt(noise**2 + (config.edge_sigma * pixel) ** 2 + (narrow * pixel) ** 2)


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


def meets_itself(sections: Sections, typical: Array, inked: Flags) -> Flags:
    """Where (N,) ink of another pass of the path lies on the cross segment of this one.

    ``typical`` (N,) are the widths to be expected [m].
    """
    met = np.zeros(len(typical), bool)
    index = np.flatnonzero(inked & np.isfinite(typical))
    if len(index) == 0:
        return met
    half, foot, margin = typical / 2, sections.foot, sections.pixel
    pairs = cKDTree(foot[index]).query_pairs(
        2 * float(half[index].max()) + margin, output_type='ndarray')
    pairs = index[pairs]
    # Most are neighbours on one pass.
    apart = np.abs(np.diff(sections.index[pairs], axis=1)[:, 0]) * sections.spacing
    pairs = pairs[apart > half[pairs].sum(axis=1)]
    for one, other in (pairs.T, pairs[:, ::-1].T):
        away = foot[other] - foot[one]
        across = np.abs(np.einsum('nk,nk->n', away, sections.lateral[one]))
        distance = np.linalg.norm(away, axis=1)
        along = np.sqrt(np.maximum(distance**2 - across**2, 0.0))
        reached = np.hypot(np.maximum(across - half[one] - margin, 0.0), along) < half[other]
        # A bend of one pass is no longer than half a circle on its chord, and some.
        arc = np.abs(sections.index[one] - sections.index[other]) * sections.spacing
        met[one[reached & (arc > np.pi / 2 * distance + half[one] + half[other])]] = True
    return met
