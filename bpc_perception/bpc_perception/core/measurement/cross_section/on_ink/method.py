"""Strokes that lie on ink: by the picture where bed is beside them, else by the cloud.

Where the same ink lies below, colour tells no edge: the strand below goes on beside the one above.
The cloud shows where the upper bead comes down.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.cross_section.by_cloud.cloud_beads import BeadModel
from bpc_perception.core.measurement.cross_section.by_cloud.rough_beads import rough_beads
from bpc_perception.core.measurement.cross_section.edges.edges import Edges
from bpc_perception.core.measurement.cross_section.edges.feet import lean_to_left
from bpc_perception.core.measurement.cross_section.height import Shapes, TOO_DEEP_M
from bpc_perception.core.measurement.cross_section.method import (
    Known,
    Picture,
    points_beside,
    read_picture,
)
from bpc_perception.core.measurement.cross_section.on_ink.bead import fit_beads
from bpc_perception.core.measurement.cross_section.on_ink.below import (
    Below,
    cloud_sinks,
    goes_on_beside,
    hangs,
    ink_beneath,
    ink_of_layer_below,
    normals_measured,
    reach_of_ink_below,
    rests,
    SUPPORTED_FOOT_SIGMA_M,
    unknown_surface,
)
from bpc_perception.core.measurement.cross_section.on_ink.cliffs import breaks_off
from bpc_perception.core.measurement.cross_section.on_ink.gaps import missing_ink
from bpc_perception.core.measurement.cross_section.on_ink.widths import (
    find_widths,
    LEAST_TOP,
    Widths,
)
from bpc_perception.core.measurement.cross_section.passes import meets_other_pass
from bpc_perception.core.measurement.cross_section.sections.sampling import Footing, lay_sections
from bpc_perception.core.measurement.cross_section.sections.sections import Sections
from bpc_perception.core.measurement.cross_section.size import (
    crosswise,
    MIDDLE,
    shapes_between,
    sizes,
)
from bpc_perception.core.measurement.samples import Samples, Sizes
from bpc_perception.core.measurement.track import Track
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.measurement.view import View
from bpc_perception.core.profile import Cause, Status

DEPTH_SIGMA = 0.15  # of how deep light goes, as a share of it
LOOSE_FOOT_SIGMA_M = 5e-4  # of the height of the foot of a bead that hangs here and there


def measure_on_ink(view: View, track: Track, bed: Plane, config: ThicknessConfig, index: Index,
                   below: Below, known: Known | None, laid: Samples) -> Samples:
    """Measure points of a track that lie on ink, all of one layer.

    Args:
        view: the capture.
        track: P points of a path, all that ink in view may come from.
        bed: plane of the bed.
        config: how to measure.
        index: (N,) of the points to measure.
        below: what is known of the ink below.
        known: of the ink on the bed; None = nothing.
        laid: what is known of the P points.
    """
    normal = normals_measured(track, index, bed, laid, config.cross_section.tangent_length)
    sections = lay_sections(view, track, index, bed, config, Footing(below.clearance, normal))
    slope = -lean_to_left(view, sections, bed.normal)
    contrast, model = (known.contrast, known.model) if known is not None else (None, None)
    sinks = cloud_sinks(track, index, laid)
    depth = depth_of_light(model, below) if sinks else 0.0
    if depth:
        sections = lifted(sections, depth, -slope)
    middle, width = rough_beads(sections)
    goes_on = goes_on_beside(sections, track, index, bed, below.width)
    sections = replace(sections, foreign=sections.foreign | goes_on,
                       nearing=sections.nearing | goes_on)
    picture = read_picture(view, sections, track.extruding[index], bed, config, contrast)
    beneath = ink_beneath(track, index, bed, below.width)
    cliffs = breaks_off(sections, goes_on & (np.abs(sections.offset) < below.width), beneath)
    beads = None if sinks and not depth else fit_beads(sections, middle, width)
    cross = crosswise(sections, normal, np.arange(len(index)))
    reach = reach_of_ink_below(track, index, bed, sections, below.width, laid, slope)
    find = partial(find_widths, sections, slope, cliffs=cliffs, reach=reach, beads=beads,
                   edge_sigma=config.cross_section.edge_sigma * sections.pixel, beneath=beneath,
                   depth_sigma=DEPTH_SIGMA * depth)
    widths = find((picture.left, picture.right))
    sides = points_beside(sections, widths.left, widths.right)
    # The flanks tell better than the nozzle how deep a bead hangs, but not where it rests.
    lies = rests(beneath, sections)
    shapes = shapes_between(cross.inside(sides, lies), sides,
                            np.where(lies, SUPPORTED_FOOT_SIGMA_M, LOOSE_FOOT_SIGMA_M),
                            round_like=below.roundness)
    # Seen from the side, the edges of one that hangs are elsewhere.
    outwards = np.where(hangs(beneath), slope, 0.0)
    widths = find((at_feet(picture.left, shapes, outwards),
                   at_feet(picture.right, shapes, -outwards)))
    sides = points_beside(sections, widths.left, widths.right)
    layer = int(track.layer[index[0]])
    lower = ink_of_layer_below(track, layer, bed, below, laid)
    before, before_sigma = (
        unknown_surface(len(index)) if lower is None
        else lower.surface(sections, sides, shapes.roundness, normal, bed))
    found = sizes(shapes, sides, widths.sigma, before, before_sigma)
    if sinks or (lower is None and (
            laid.status[track.layer == layer - 1] == Status.MEASURED).any()):
        found = Sizes.unknown(len(index))  # its own height was refused
    gap = (np.zeros(len(index), bool) if beads is None
           else missing_ink(sections, beads, widths.sure, before[:, MIDDLE]))
    return Samples(sides, judged(sections, picture, widths, found.height, gap), widths.sigma,
                   found, np.full(len(index), view.number))


def depth_of_light(model: BeadModel | None, below: Below) -> float:
    """Return how deep light goes into ink whose heights were refused [m]; 0 = not known.

    The ink on the bed tells. If it goes less deep than shows in heights, they contradict each
    other.
    """
    if model is None:
        return 0.0
    depth = model.depth * below.width / 2
    return depth if depth >= TOO_DEEP_M else 0.0


def lifted(sections: Sections, depth: float, lean: Array) -> Sections:
    """Return sections with their points moved to the surface of ink into which light goes.

    Args:
        sections: N sections.
        depth: how far below the surface the points lie [m].
        lean: (N,) see ``lean_to_left``; points lie behind the surface along the camera's rays.
    """
    aside = (depth * lean).astype(np.float32)[:, None]
    return replace(sections, height=sections.height + np.float32(depth),
                   place=sections.place - aside)


def at_feet(edges: Edges, shapes: Shapes, slope: Array) -> Edges:
    """Return where N edges are that were taken to be as high as the feet of the sections.

    Args:
        edges: on one side.
        shapes: of the beads; their feet are higher by their level.
        slope: (N,) how far a place seems to be shifted outwards, per height above the foot.
    """
    raised = np.nan_to_num(slope * shapes.level)
    return replace(edges, distance=edges.distance + raised)


def judged(sections: Sections, picture: Picture, widths: Widths, height: Array,
           gap: Flags) -> Verdicts:
    """Return what is known of each sample.

    Args:
        sections: N sections.
        picture: what it says of them.
        widths: of the beads.
        height: (N,) of them above what lay there before [m].
        gap: (N,) whether ink is missing.
    """
    seen = picture.verdicts
    unseen = np.isin(seen.status, (Status.OCCLUDED, Status.NO_DATA))
    crossing = meets_other_pass(sections, widths.width, np.ones(len(unseen), bool))
    # Of hardly any height, it is the ink below that is so wide.
    known = height[np.isfinite(height)]
    sure = widths.sure & ~(height < LEAST_TOP * (np.median(known) if len(known) else 0.0))
    told = Verdicts.by_first(
        [(crossing, Status.JUNCTION, Cause.NONE), (gap, Status.GAP, Cause.NONE),
         (sure, Status.MEASURED, Cause.NONE)],
        Verdicts.all_of(len(unseen), Status.LOW_CONFIDENCE, Cause.ON_INK))
    return told.with_part(np.flatnonzero(unseen), seen.of(np.flatnonzero(unseen)))
