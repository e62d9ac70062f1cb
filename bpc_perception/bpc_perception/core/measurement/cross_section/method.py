"""Thickness from the image across the path: the default method.

The image is read along a line across each path point. The edge is where it passes half-way from
ink to what lies beside it, to a fraction of a pixel. The path says which edge is meant: the first
on either side, going outward. What ink and bed look like is taken from the image itself, near each
point: ink lies along the path, bed far from all of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.config import CrossSectionConfig, ThicknessConfig
from bpc_perception.core.filters import thinned
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.cross_section.appearance.appearance import (
    Appearance,
    find_appearance,
    UNTOLD,
)
from bpc_perception.core.measurement.cross_section.appearance.contrast import Contrast
from bpc_perception.core.measurement.cross_section.appearance.ink import ink_share
from bpc_perception.core.measurement.cross_section.by_cloud.cloud_beads import (
    BeadModel,
    CloudBeads,
)
from bpc_perception.core.measurement.cross_section.edges.edges import Edges, find_edges
from bpc_perception.core.measurement.cross_section.edges.feet import (
    Feet,
    find_feet,
    lean_to_left,
)
from bpc_perception.core.measurement.cross_section.judgement import (
    ends_within_pixel,
    judge,
    look_at_middle,
)
from bpc_perception.core.measurement.cross_section.second_opinion import (
    ask_cloud,
    lines_in_picture,
    Told,
    told_by_both,
)
from bpc_perception.core.measurement.cross_section.sections.sampling import lay_sections
from bpc_perception.core.measurement.cross_section.sections.sections import Sections
from bpc_perception.core.measurement.cross_section.size import sizes_on_bed
from bpc_perception.core.measurement.samples import Samples
from bpc_perception.core.measurement.scale import steady_step
from bpc_perception.core.measurement.side_points import SidePoints
from bpc_perception.core.measurement.track import Track
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.measurement.view import View
from bpc_perception.core.profile import Cause, Status

LIGHT_WIDTH_PX = 10.0  # of the bead for which ``light_sigma`` is given
FEW_PIXELS = 6.0  # across a bead; its edges are not seen apart
PICTURE, CLOUD, SIGMA = range(3)  # of what feet tell


@dataclass(frozen=True)
class Known:
    """What all of a print tells, and a part of it needs.

    Attributes:
        contrast: of ink and bed.
        feet: how far beads go on beyond what shows their edges.
        model: what they look like in the cloud; None = it shows none.
    """

    contrast: Contrast
    feet: Feet
    model: BeadModel | None


@dataclass(frozen=True)
class CrossSections:
    """What is known of N path points, and of the print as a whole.

    Attributes:
        samples: of the path points.
        known: of all of the print; None = ink and bed are not told apart.
    """

    samples: Samples
    known: Known | None


@dataclass(frozen=True)
class Picture:
    """What the picture says of N sections.

    Attributes:
        left, right: the edges.
        verdicts: what it says of each.
        contrast: of ink and bed; None = nothing is told apart.
        ink: (N, M) share of ink in each sample.
    """

    left: Edges
    right: Edges
    verdicts: Verdicts
    contrast: Contrast | None
    ink: Floats


def measure_cross_sections(view: View, track: Track, bed: Plane, config: ThicknessConfig,
                           index: Index | None = None,
                           known: Known | None = None) -> CrossSections:
    """Measure a track, or some points of it.

    Args:
        view: the capture.
        track: P points of a path, all that ink in view may come from.
        bed: plane of the bed.
        config: how to measure.
        index: (N,) of the points to measure; None = all. The ends of a part are not known well.
        known: what the whole print tells, which a part needs.
    """
    index = np.arange(len(track)) if index is None else index
    sections = lay_sections(view, track, index, bed, config)
    picture = read_picture(view, sections, track.extruding[index], bed, config,
                           known.contrast if known is not None else None)
    left, right, lean = picture.left, picture.right, lean_to_left(view, sections, bed.normal)
    lines = lines_in_picture(sections, left, right, picture.verdicts)
    beads, model, of_use = ask_cloud(sections, lean, lines,
                                     known.model if known is not None else None)
    feet = known.feet if known is not None else find_feet(
        sections, picture.ink, left, right, lean, picture.verdicts.status == Status.MEASURED,
        beads, model.sigma if model is not None and of_use else np.nan)
    most, doubt = config.cross_section.maximum_sigma, width_doubt(
        left, right, sections.pixel, config.cross_section)
    by_picture, by_cloud = told_at_feet(sections, feet, lean, (left, right), doubt, beads, model)
    doubt[Cause.UNSURE_FEET] = by_picture.common
    verdicts = without_unsure(picture.verdicts, doubt, by_picture.total <= most * by_picture.width,
                              by_picture.width < FEW_PIXELS * sections.pixel)
    told, verdicts = told_by_both(by_picture, by_cloud, beads, verdicts, sections, most,
                                  picture_of_use=of_use)
    sides = points_beside(sections, told.left, told.right)
    return CrossSections(
        Samples(sides, verdicts, told.total, sizes_on_bed(sections, sides, told.total, bed),
                np.full(len(index), view.number)),
        Known(picture.contrast, feet, model) if picture.contrast is not None else None)


def read_picture(view: View, sections: Sections, extruding: Flags, bed: Plane,
                 config: ThicknessConfig, known: Contrast | None) -> Picture:
    """Return what the picture says of N sections.

    Args:
        view: the capture.
        sections: N sections.
        extruding: (N,) whether ink was being pushed out.
        bed: plane of the bed.
        config: how to measure.
        known: the contrast of the whole print; None = these sections tell it.
    """
    appearance = appearance_along(sections, extruding, known)
    ink = ink_share(sections, appearance)
    right, left = find_edges(sections, appearance.noise, ink)
    most = config.cross_section.maximum_noise
    verdicts = judge(sections, ink, left, right, untold=appearance.untold(most),
                     faint=appearance.noise > most / 2,
                     ending=ends_within_pixel(view, sections, appearance, bed.normal))
    return Picture(left, right, verdicts, appearance.contrast, ink)


def look_for_ink(view: View, track: Track, bed: Plane, config: ThicknessConfig, index: Index,
                 known: Contrast) -> Verdicts:
    """Return whether ink is seen at travel points of a track (K,): OOZE, BARE, or why neither.

    Arguments are as for ``measure_cross_sections``. A string is thin: what lies right below the
    nozzle counts, and no width is needed.
    """
    sections = lay_sections(view, track, index, bed, config)
    appearance = appearance_along(sections, track.extruding[index], known)
    middle = look_at_middle(sections, ink_share(sections, appearance),
                            np.full(len(index), np.nan))
    on_path = sections.on_path
    untold = appearance.untold(config.cross_section.maximum_noise)
    return Verdicts.by_first(
        [(sections.hidden[:, on_path], Status.OCCLUDED, Cause.NONE),
         (~sections.inside[:, on_path], Status.NO_DATA, Cause.OUTSIDE_IMAGE),
         (~sections.depth, Status.NO_DATA, Cause.NO_DEPTH),
         *((untold == cause, Status.LOW_CONFIDENCE, cause) for cause in UNTOLD),
         (middle.inked, Status.OOZE, Cause.NONE),
         (middle.bare & ~sections.raised, Status.BARE, Cause.NONE),
         (middle.bare, Status.LOW_CONFIDENCE, Cause.RAISED),
         (middle.glary, Status.LOW_CONFIDENCE, Cause.GLARE)],
        Verdicts.all_of(len(index), Status.LOW_CONFIDENCE, Cause.PARTLY_INK))


def appearance_along(sections: Sections, extruding: Flags, known: Contrast | None) -> Appearance:
    """Find the appearance at each section; light changes slowly, so not every one is looked at."""
    step = steady_step(sections.spacing)
    asked = thinned(sections.piece, step)
    near = np.rint(np.interp(np.arange(len(sections.piece)), asked, np.arange(len(asked))))
    return find_appearance(sections.of(asked, step), extruding[asked], known).at(
        near.astype(np.intp))


def told_at_feet(sections: Sections, feet: Feet, lean: Array, edges: tuple[Edges, Edges],
                 doubt: dict[Cause, Array], beads: CloudBeads,
                 model: BeadModel | None) -> tuple[Told, Told]:
    """Return where the feet of N beads are by their edges in the picture, and by the cloud.

    Args:
        sections: N sections.
        feet: how far they lie outward of both.
        lean: (N,) how far the top of a bead seems shifted to the left, per height.
        edges: on the left and on the right.
        doubt: see ``width_doubt``.
        beads: in the cloud.
        model: what they look like there; None = there are none.
    """
    own = np.sqrt(sum(part**2 for part in doubt.values()))
    left, right = ([part * sections.pixel for part in feet.outward(one)] for one in (lean, -lean))
    common = left[SIGMA] + right[SIGMA]
    picture = Told(edges[0].distance + left[PICTURE], edges[1].distance + right[PICTURE],
                   own, common)
    compared = np.isfinite(left[CLOUD] + right[CLOUD])
    alone = beads.width * (np.nan if model is None else model.sigma)
    cloud = Told(beads.left + np.nan_to_num(left[CLOUD]),
                 beads.right + np.nan_to_num(right[CLOUD]), beads.sigma,
                 np.where(compared, common, alone), compared)
    return picture, cloud


def points_beside(sections: Sections, left: Array, right: Array) -> SidePoints:
    """Return the side points of N sections at distances (N,) from the path [m]."""
    return SidePoints(sections.foot + left[:, None] * sections.lateral,
                      sections.foot - right[:, None] * sections.lateral, left, right)


def without_unsure(verdicts: Verdicts, doubt: dict[Cause, Array], sure: Flags,
                   narrow: Flags) -> Verdicts:
    """Return what is known of N samples, of which widths that are not sure (N,) are not told.

    Args:
        verdicts: of the samples.
        doubt: (N,) parts of the widths' 1-sigma uncertainty [m]; the largest is the cause.
        sure: (N,) whether a width is sure enough to be told.
        narrow: (N,) whether it has so few pixels that this is the cause in any case.
    """
    unsure = (verdicts.status == Status.MEASURED) & ~sure
    largest = np.argmax(np.stack([np.nan_to_num(part, nan=np.inf) for part in doubt.values()]),
                        axis=0)
    return Verdicts.by_first(
        [(unsure & narrow, Status.LOW_CONFIDENCE, Cause.FEW_PIXELS),
         *((unsure & (largest == place), Status.LOW_CONFIDENCE, cause)
           for place, cause in enumerate(doubt))], verdicts)


def width_doubt(left: Edges, right: Edges, pixel: float,
                config: CrossSectionConfig) -> dict[Cause, Array]:
    """Return the 1-sigma uncertainty (N,) of the width between two edges in its parts [m].

    There is the noise of both edges; what sampling leaves; and the light on the bead, which shades
    its edges and shines on its ridge. The fewer pixels the bead has, the less of that is seen
    apart.
    """
    noise = config.noise_gain * np.hypot(left.sigma, right.sigma)
    width = left.distance + right.distance
    narrow = config.light_sigma * (LIGHT_WIDTH_PX * pixel / width) ** 2
    return {Cause.FAINT_EDGES: noise,
            Cause.FEW_PIXELS: pixel * np.hypot(config.edge_sigma, narrow)}
