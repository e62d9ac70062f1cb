"""Strokes that lie on ink: by the picture where bed is beside them, else by the cloud.

Where the same ink lies below, colour tells no edge: the strand below goes on beside the one above.
The cloud shows where the upper bead comes down. Where both know the width they have to agree: the
picture is the sharper one, and is believed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import maximum_filter1d
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.filters import masked_median, running_mean
from bpc_perception.core.geometry import Plane, unit_vectors
from bpc_perception.core.measurement.cross_section.appearance.contrast import Contrast
from bpc_perception.core.measurement.cross_section.bead import (
    Beads,
    fit_beads,
    HALF_LEVEL,
    POOLED_M,
)
from bpc_perception.core.measurement.cross_section.edges.edges import Edges
from bpc_perception.core.measurement.cross_section.method import read_picture, side_points
from bpc_perception.core.measurement.cross_section.passes import meets_other_pass
from bpc_perception.core.measurement.cross_section.sections.sampling import Footing, lay_sections
from bpc_perception.core.measurement.cross_section.sections.sections import Sections
from bpc_perception.core.measurement.cross_section.sections.territory import find_nearest
from bpc_perception.core.measurement.samples import Samples
from bpc_perception.core.measurement.track import Track
from bpc_perception.core.measurement.view import View
from bpc_perception.core.profile import Status, StatusArray

# Of the height of a bead's foot below the nozzle, where it lies on ink and where it hangs.
SUPPORTED_FOOT_SIGMA_M, HANGING_FOOT_SIGMA_M = 4e-5, 1e-4
HANGS = 1.5  # layers above the next ink below
# Of the first layer, every so many path points within a reach tell how the bed lies, if they are
# not all on a line.
BED_STEP, BED_REACH_M, LEAST_SPREAD_M = 5, 6e-3, 2e-4
CLIFF_SHARE = 0.7  # of a layer that the cloud goes down; a bead may hang down by the rest
CLIFF_SIGMA_PX = 0.3  # of a place known to a pixel, which is the same all along a straight edge
# Along so much path, the width of a bead changes at random by this share of it.
WALK_M, WALK_SHARE = 1e-3, 0.03
CROSSING_MARGIN_PX = 3.0  # along the path, beside a strand below
MOST_SHOWN_PX = 0.25  # of ink below beyond a bead, where its edge is seen all the same
AGREE_SIGMAS = 3.0  # within which picture and cloud agree
# Ink of a layer below goes on where its path is so much nearer than the section's own, from this
# share of its width on.
MUCH_NEARER, WITHIN = 0.8, 0.4
# By how much, as a share of the usual width, one may differ that the cloud tells in part, and one
# of which both edges are seen.
MOST_UNLIKE, MOST_UNLIKE_SEEN = 0.15, 0.25
USUAL_M, LEAST_SURE = 8e-3, 10  # so far around, so many samples tell what is usual
LEAST_TOP = 0.3  # of the usual height of a bead; what is lower is none
LARGEST_SIGMA = 0.15  # of a width that the cloud alone tells, as a share of it


Known = tuple[Array, Array]  # values and their sigmas, (N,) each


@dataclass(frozen=True)
class Beneath:
    """How far below the nozzle's height at N beads it had passed over ink under them; NaN = none.

    Attributes:
        lowest, highest: (N,) of that ink [m].
    """

    lowest: Array
    highest: Array

    @property
    def layer_height(self) -> float:
        """From the layer below to this one [m]; 0 = not known."""
        known = np.isfinite(self.highest)
        return float(self.highest[known].min()) if known.any() else 0.0


@dataclass(frozen=True)
class Below:
    """What is known of the layers below.

    Attributes:
        clearance: how high above the feet of beads the nozzle passes [m].
        width: of the ink below [m].
    """

    clearance: float
    width: float


def measure_on_ink(view: View, track: Track, bed: Plane, config: ThicknessConfig, index: Index,
                   below: Below, known: Contrast | None) -> Samples:
    """Measure points of a track that lie on ink, all of one layer.

    Args:
        view: the capture.
        track: P points of a path, all that ink in view may come from.
        bed: plane of the bed.
        config: how to measure.
        index: (N,) of the points to measure.
        below: what is known of the ink below.
        known: the contrast of the whole print; None = not known.
    """
    sections = lay_sections(view, track, index, bed, config,
                            Footing(below.clearance, normals_below(track, index, bed)))
    middle, width = rough_beads(sections)
    goes_on = goes_on_beside(sections, track, index, bed, below.width)
    sections = replace(sections, foreign=sections.foreign | goes_on)
    picture = read_picture(view, sections, track.extruding[index], bed, config, known)
    beads = fit_beads(sections, middle, width)
    beneath = ink_beneath(track, index, bed, below.width)
    cliffs = breaks_off(sections, goes_on & (np.abs(sections.offset) < below.width), beneath)
    return combined(view, sections, bed, beneath, (picture.left, picture.right), cliffs,
                    picture.status, config.cross_section.edge_sigma * sections.pixel, beads)


def normals_below(track: Track, index: Index, bed: Plane) -> Array:
    """Return the normals (N, 3) of the bed below points of a track, which may bend.

    The nozzle kept its height above the bed along the first layer.
    """
    first = np.flatnonzero(track.layer == 0)[::BED_STEP]
    axes = bed.coordinates(np.eye(3))
    asked = np.arange(0, len(index) + BED_STEP - 1, BED_STEP).clip(max=len(index) - 1)
    slope = np.zeros((len(asked), 2))
    if len(first):
        place, height = bed.coordinates(track.points[first]), bed.height(track.points[first])
        there = bed.coordinates(track.points[index[asked]])
        near = cKDTree(place).query_ball_point(there, BED_REACH_M)
        for number, found in enumerate(near):
            if len(found) > 2:
                off = place[found] - place[found].mean(axis=0)
                rise = height[found] - height[found].mean()
                # Across a single line nothing is known: then it is taken to be level.
                slope[number] = np.linalg.solve(
                    off.T @ off + len(found) * LEAST_SPREAD_M**2 * np.eye(2), off.T @ rise)
    every = np.arange(len(index))
    slope = np.stack([np.interp(every, asked, each) for each in slope.T], axis=1)
    return unit_vectors(bed.normal - slope @ axes.T)


def goes_on_beside(sections: Sections, track: Track, index: Index, bed: Plane,
                   below: float) -> Flags:
    """Return where (N, M) ink of a layer below goes on beside the bead, so that it has no edge.

    Args:
        sections: N sections with M samples each.
        track: P points.
        index: (N,) of the sections, all of one layer.
        bed: plane of the bed.
        below: width of the ink below [m].
    """
    lower = (track.layer >= 0) & (track.layer < track.layer[index].min())
    if not lower.any():
        return np.zeros(sections.foreign.shape, bool)
    _, away = find_nearest(bed.coordinates(track.points[lower]), bed.coordinates(sections.foot),
                           bed.coordinates(sections.lateral), sections.offset)
    # A strand that runs along below has edges of its own there, which are told apart by the cloud.
    out = np.abs(sections.offset)
    return np.asarray((away < below / 2 + sections.pixel) & (away < MUCH_NEARER * out)
                      & (out > WITHIN * below))


def rough_beads(sections: Sections) -> tuple[Array, Array]:
    """Return middle and width (N,) of beads, from where they come down to half their height [m].

    NaN where they do not on both sides.
    """
    height = np.where(sections.visible, sections.height, np.nan)
    central = height[:, np.abs(sections.offset) <= 2 * sections.pixel]
    ridge = sections.steady(masked_median(central, np.isfinite(central)))
    down = height < ridge[:, None] / 2
    middle = sections.on_path
    left, right = (_last_before(sections.place[:, side], down[:, side])
                   for side in (slice(middle, None), slice(middle, None, -1)))
    width = sections.steady((left - right) / HALF_LEVEL)
    return sections.steady((left + right) / 2), width


def ink_beneath(track: Track, index: Index, bed: Plane, width: float) -> Beneath:
    """Return which ink lies under beads.

    Args:
        track: P points.
        index: (N,) of the beads, all of one layer.
        bed: plane of the bed.
        width: of the ink below [m].
    """
    lowest, highest = np.full((2, len(index)), np.nan)
    lower = np.flatnonzero((track.layer >= 0) & (track.layer < track.layer[index].min()))
    height = bed.height(track.points)
    if len(lower):
        found = cKDTree(bed.coordinates(track.points[lower])).query_ball_point(
            bed.coordinates(track.points[index]), width / 2)
        for number, near in enumerate(found):
            if near:
                heights = height[lower[near]]
                lowest[number] = height[index[number]] - heights.min()
                highest[number] = height[index[number]] - heights.max()
    return Beneath(lowest, highest)


def breaks_off(sections: Sections, goes_on: Flags, beneath: Beneath) -> tuple[Array, Array]:
    """Return how far (N,) to the left and to the right beads break off in the cloud [m].

    There the cloud goes down by most of a layer, from one of its points to the next. NaN = it does
    not, or a strand below goes on there (N, M).
    """
    level = -CLIFF_SHARE * beneath.layer_height
    down, up = sections.height < level, sections.height >= level
    middle = sections.on_path
    along = 2 * round(CROSSING_MARGIN_PX * sections.pixel / sections.spacing) + 1
    found = []
    for side in (slice(middle, None), slice(middle, None, -1)):
        before = np.cumsum(down[:, side], axis=1) == 0
        last, first = _last(before & up[:, side]), before.sum(axis=1)
        crossed = maximum_filter1d(goes_on[:, side].any(axis=1), along)
        place = np.where((last >= 0) & (first < before.shape[1]) & ~crossed,
                         (last + first) / 2, np.nan)
        found.append(_mean_around(place * (sections.offset[1] - sections.offset[0]), sections))
    return found[0], found[1]


def combined(view: View, sections: Sections, bed: Plane, beneath: Beneath,
             edges: tuple[Edges, Edges], cliffs: tuple[Array, Array], status: StatusArray,
             sigma: float, beads: Beads) -> Samples:
    """Return what picture and cloud say together of N sections.

    Args:
        view: the capture.
        sections: N sections.
        bed: plane of the bed.
        beneath: which ink lies under the beads.
        edges: in the picture, on the left and on the right.
        cliffs: (N,) where beads break off in the cloud, on both sides [m].
        status: (N,) what the picture says.
        sigma: of an edge in the picture, beside its noise [m].
        beads: what the cloud says.
    """
    to_camera = view.viewpoint - sections.foot
    slope = np.einsum('nk,nk->n', to_camera, sections.lateral) / (to_camera @ bed.normal)
    foot = np.where(beneath.highest < HANGS * beneath.layer_height, SUPPORTED_FOOT_SIGMA_M,
                    HANGING_FOOT_SIGMA_M)
    (left, left_sigma), (right, right_sigma) = sides = [
        _side(*each, sections, sigma, np.nan_to_num(beneath.lowest))
        for each in zip(edges, cliffs, (slope, -slope), strict=True)]
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
    carried = carried_along(*seen, sections)
    width, width_sigma = best_of(seen, mean_of(carried, by_cloud))
    with np.errstate(invalid='ignore'):
        usual = np.nanmedian(beads.top) if np.isfinite(beads.top).any() else np.nan
        agree = np.abs(width - by_cloud[0]) <= AGREE_SIGMAS * np.hypot(width_sigma, by_cloud[1])
        sure = agree & (beads.top > LEAST_TOP * usual) & (width_sigma <= LARGEST_SIGMA * width)
    # An edge among those of ink below may be theirs: what is told has to go on along the bead.
    usual_width = usual_around(np.where(sure, width, np.nan), sections)
    with np.errstate(invalid='ignore'):
        sure &= np.abs(width - usual_width) <= usual_width * np.where(
            pictured, MOST_UNLIKE_SEEN, MOST_UNLIKE)
    crossing = meets_other_pass(sections, width, np.ones(len(status), bool))
    both = np.isfinite(left + right) & (width == left + right)
    points = side_points(sections, _edges_at(np.where(both, left, beads.middle + width / 2)),
                         _edges_at(np.where(both, right, width / 2 - beads.middle)))
    unseen = np.isin(status, (Status.OCCLUDED, Status.NO_DATA))
    status = np.select([unseen, crossing, sure], [status, Status.JUNCTION, Status.MEASURED],
                       Status.LOW_CONFIDENCE).astype(np.uint8)
    return Samples(points, status, width_sigma)


def usual_around(width: Array, sections: Sections) -> Array:
    """Return the median (N,) of the widths known around each on the same bead; NaN = too few."""
    reach = round(USUAL_M / sections.spacing)
    padded = [np.pad(values, reach, constant_values=np.nan)
              for values in (width, sections.piece.astype(float))]
    around, piece = (sliding_window_view(values, 2 * reach + 1) for values in padded)
    known = np.isfinite(around) & (piece == sections.piece[:, None])
    return np.where(known.sum(axis=1) >= LEAST_SURE, masked_median(around, known), np.nan)


def best_of(*known: Known) -> Known:
    """Return the values (N,) with the smallest sigma (N,); NaN where nothing is known."""
    values, sigmas = (np.stack(each) for each in zip(*known, strict=True))
    best = np.argmin(np.where(np.isfinite(values + sigmas), sigmas, np.inf), axis=0)[None]
    return (np.take_along_axis(values, best, axis=0)[0],
            np.take_along_axis(sigmas, best, axis=0)[0])


def mean_of(*known: Known) -> Known:
    """Return the means (N,) of what is known, weighed by its sigmas (N,); NaN where nothing is."""
    values, sigmas = (np.stack(each) for each in zip(*known, strict=True))
    weights = np.where(np.isfinite(values + sigmas), sigmas, np.inf)**-2.0
    total = weights.sum(axis=0)
    with np.errstate(invalid='ignore', divide='ignore'):
        return np.nansum(weights * values, axis=0) / total, total**-0.5


def carried_along(width: Array, sigma: Array, sections: Sections) -> Known:
    """Return widths (N,) to be expected from those seen before and behind on a bead [m].

    The width walks at random along the path: the farther away it is seen, the less is known.
    """
    width, around = _mean_around(width, sections), np.isfinite(width)
    walk = (WALK_SHARE * np.nanmedian(width))**2 if around.any() else np.nan
    index, known = np.arange(len(width)), np.flatnonzero(around)
    if not len(known):
        return np.full(len(width), np.nan), np.full(len(width), np.nan)
    after = np.searchsorted(known, index)
    sides = []
    for other in (known[np.maximum(after - 1, 0)], known[np.minimum(after, len(known) - 1)]):
        far = np.abs(sections.along[other] - sections.along)
        same = sections.piece[other] == sections.piece
        sides.append((np.where(same, width[other], np.nan),
                      np.sqrt(sigma[other]**2 + walk * far / WALK_M)))
    return mean_of(*sides)


def _side(edge: Edges, cliff: Array, slope: Array, sections: Sections, sigma: float,
          depth: Array) -> tuple[Array, Array]:
    """Return where (N,) beads end on one side, with its 1-sigma uncertainty (N,) [m].

    NaN = unknown. Where ink below comes out on this side, seen from the camera, its edge is not
    the bead's: then the place counts at which the cloud breaks off.
    """
    shown = np.maximum(depth * slope, 0.0)  # the ink below is as wide
    by_picture = np.where(shown <= MOST_SHOWN_PX * sections.pixel, edge.distance, np.nan)
    known = np.isfinite(by_picture)
    return (np.where(known, by_picture, cliff),
            np.where(known, np.hypot(edge.sigma, sigma), CLIFF_SIGMA_PX * sections.pixel))


def _mean_around(values: Array, sections: Sections) -> Array:
    """Return the mean (N,) of values (N,) over a stretch around each; NaN where it has none."""
    window = 2 * round(POOLED_M / sections.spacing) + 1
    mean = running_mean(values[:, None], window, sections.piece)[:, 0]
    return np.where(np.isfinite(values), mean, np.nan)


def _last(flags: Flags) -> Index:
    """Return where (N,) the last True is in each row (N, K); -1 = nowhere."""
    return np.where(flags.any(axis=1), flags.shape[1] - 1 - np.argmax(flags[:, ::-1], axis=1), -1)


def _edges_at(distance: Array) -> Edges:
    none = np.zeros(len(distance), bool)
    return Edges(distance, np.zeros(len(distance)), none, none, none)


def _last_before(place: Floats, down: Flags) -> Array:
    """Return the last place (N,) in rows (N, K) before the first that is down; NaN = none."""
    last = _last((np.cumsum(down, axis=1) == 0) & np.isfinite(place))
    found = (last >= 0) & down.any(axis=1)
    return np.where(found, place[np.arange(len(place)), last], np.nan)
