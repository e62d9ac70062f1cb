"""What lies below a stroke on ink: how high its feet are, and the surface before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.geometry import Plane, unit_vectors
from bpc_perception.core.measurement.cross_section.height import (
    ANY_ROUNDNESS,
    Roundness,
    shape,
    SHAPED_M,
)
from bpc_perception.core.measurement.cross_section.sections.sections import Sections
from bpc_perception.core.measurement.cross_section.sections.territory import find_nearest
from bpc_perception.core.measurement.cross_section.size import MIDDLE, U
from bpc_perception.core.measurement.samples import Samples
from bpc_perception.core.measurement.side_points import SidePoints
from bpc_perception.core.measurement.track import Track
from bpc_perception.core.path.tangents import smoothed_tangents
from bpc_perception.core.profile import Status

# Of the height of a bead's foot below the nozzle, where it lies on ink and where it hangs.
SUPPORTED_FOOT_SIGMA_M, HANGING_FOOT_SIGMA_M = 4e-5, 1e-4
HANGS = 1.5  # layers above the next ink below
# Of the first layer, every so many path points within a reach tell how the bed lies, if they are
# not all on a line.
BED_STEP, BED_REACH_M, LEAST_SPREAD_M = 5, 6e-3, 2e-4
NORMALS = 6  # so many near places of the first layer tell how the bed lies
# Ink of a layer below goes on where its path is so much nearer than the section's own, from this
# share of its width on.
MUCH_NEARER, WITHIN = 0.8, 0.4
# So many samples of the layer below tell whether light goes into the ink: then fewer of them have
# a height than this share.
LEAST_BELOW, LEAST_SIZED = 10, 0.5
UNSEEN_SIGMA = 0.2  # of the height of ink below that was not measured, as a share of it


@dataclass(frozen=True)
class Below:
    """What is known of the layers below.

    Attributes:
        clearance: how high above the feet of beads the nozzle passes [m].
        width: of the ink below [m].
        roundness: of the ink on the bed.
    """

    clearance: float
    width: float
    roundness: Roundness = ANY_ROUNDNESS


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


def normals_measured(track: Track, index: Index, bed: Plane, laid: Samples,
                     tangent_length: float) -> Array:
    """Return the normals (N, 3) of the bed below points of a track, which may bend.

    The side points of the first layer tell how the bed lies across its strokes, and the path how
    it lies along them. Where none was measured, see ``normals_by_path``.

    Args:
        track: P points.
        index: (N,) of those asked for.
        bed: plane of the bed.
        laid: what is known of the P points.
        tangent_length: of the path that tells its direction [m].
    """
    first = np.flatnonzero((track.layer == 0) & (laid.status == Status.MEASURED))[::BED_STEP]
    along = smoothed_tangents(track.points, track.piece, first, tangent_length)
    normal = unit_vectors(np.cross(along, (laid.sides.left - laid.sides.right)[first]))
    known = np.isfinite(normal).all(axis=1)
    if known.sum() < NORMALS:
        return normals_by_path(track, index, bed)
    _, near = cKDTree(bed.coordinates(track.points[first[known]])).query(
        bed.coordinates(track.points[index]), NORMALS)
    return unit_vectors(normal[known][near].mean(axis=1))


def normals_by_path(track: Track, index: Index, bed: Plane) -> Array:
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


def reach_of_ink_below(track: Track, index: Index, bed: Plane, sections: Sections, width: float,
                       laid: Samples, slope: Array) -> Array:
    """Return how far out (2, N) ink of lower layers seems to reach, on the left and right [m].

    Where the edge of ink in a picture lies no farther out, it may be theirs. -inf = there is none.

    Args:
        track: P points.
        index: (N,) of the beads, all of one layer.
        bed: plane of the bed.
        sections: N sections.
        width: of ink below that was not measured [m].
        laid: what is known of the P points.
        slope: (N,) how far to the left what lies below seems to be shifted, per depth.
    """
    reach = np.full((2, len(index)), -np.inf)
    place, height = bed.coordinates(track.points), bed.height(track.points)
    lateral = bed.coordinates(sections.lateral)
    farther = np.maximum(laid.sides.left_distance, laid.sides.right_distance)
    half = np.where(np.isfinite(farther), farther, width / 2)
    for layer in range(int(track.layer[index[0]])):
        lower = np.flatnonzero(track.layer == layer)
        if not len(lower):
            continue
        away, near = cKDTree(place[lower]).query(place[index], distance_upper_bound=width)
        found = np.flatnonzero(np.isfinite(away))
        near = lower[near[found]]
        to_left = np.einsum('nk,nk->n', place[near] - place[index[found]], lateral[found])
        to_left += (height[index[found]] - height[near]) * slope[found]
        reach[:, found] = np.maximum(
            reach[:, found], np.stack((half[near] + to_left, half[near] - to_left)))
    return reach


def cloud_sinks(track: Track, index: Index, laid: Samples) -> bool:
    """Return whether light goes into the ink, so that its points lie too deep.

    Then the heights of the layer below were refused, and the cloud lies above it as well.

    Args:
        track: P points.
        index: (N,) of the beads, all of one layer.
        laid: what is known of the P points.
    """
    lower = track.layer == track.layer[index].min() - 1
    crest = laid.sizes.crest[lower & (laid.status == Status.MEASURED)]
    return len(crest) >= LEAST_BELOW and bool(np.isfinite(crest).mean() < LEAST_SIZED)


def hangs(beneath: Beneath) -> Flags:
    """Return which beads (N,) have no ink of the layer below under them."""
    return np.asarray(~(beneath.highest < HANGS * beneath.layer_height))


def rests(beneath: Beneath, sections: Sections) -> Flags:
    """Return which beads (N,) lie on ink as far along the path as their shape is that of."""
    around = 2 * round(SHAPED_M / sections.spacing) + 1
    return np.asarray(maximum_filter1d(hangs(beneath).view(np.uint8), around) == 0)


def foot_sigma(beneath: Beneath) -> Array:
    """Return the 1-sigma uncertainty (N,) of how high the feet of beads are [m]."""
    return np.where(hangs(beneath), HANGING_FOOT_SIGMA_M, SUPPORTED_FOOT_SIGMA_M)


@dataclass(frozen=True)
class LowerInk:
    """Ink of the layer below, at L points of its path.

    Attributes:
        foot: (L, 3) middle between its side points, in the base frame [m].
        half: (L,) half of its width [m].
        crest, sigma: (L,) its height above the foot, with its 1-sigma uncertainty [m].
    """

    foot: Array
    half: Array
    crest: Array
    sigma: Array

    def surface(self, sections: Sections, sides: SidePoints, roundness: Array, normal: Array,
                bed: Plane) -> tuple[Array, Array]:
        """Return how high it is under N beads, and its sigma (N,) in their middle [m].

        That is above the feet of the sections (N, K) at ``U``; -inf where it does not lie.

        Args:
            sections: N sections.
            sides: where the beads end.
            roundness: (N,) of the beads; the ink below is taken to be as round.
            normal: (N, 3) of the bed below them.
            bed: plane of the bed.
        """
        middle, reach = (sides.left + sides.right) / 2, (sides.left - sides.right) / 2
        place = middle[:, None] + U[:, None] * reach[:, None]
        place = np.where(np.isfinite(place), place, sections.foot[:, None])
        away, nearest = cKDTree(bed.coordinates(self.foot)).query(bed.coordinates(place))
        u = away / self.half[nearest]
        foot = np.einsum('nki,ni->nk', self.foot[nearest] - sections.foot[:, None], normal)
        # Where there is no bead, that below is as round as others.
        known = np.isfinite(roundness)
        usual = np.median(roundness[known]) if known.any() else 0.0
        high = foot + self.crest[nearest] * shape(u, np.where(known, roundness, usual)[:, None])
        return np.where(u < 1, high, -np.inf), self.sigma[nearest[:, MIDDLE]]


def unknown_surface(count: int) -> tuple[Array, Array]:
    """Return what is known where nothing is of the ink below: NaN, as ``LowerInk.surface``."""
    return np.full((count, len(U)), np.nan), np.full(count, np.nan)


def ink_of_layer_below(track: Track, layer: int, bed: Plane, below: Below,
                       laid: Samples) -> LowerInk | None:
    """Return the ink that a layer lies on; None = nothing is known of its height.

    Where it was not measured, it is taken to be like the rest of its layer.

    Args:
        track: P points.
        layer: the layer above.
        bed: plane of the bed.
        below: what is known of all ink below.
        laid: what is known of the P points.
    """
    lower = np.flatnonzero((track.layer == layer - 1) & (laid.status != Status.GAP))
    ink = laid.of(lower)
    measured = np.asarray((ink.status == Status.MEASURED) & np.isfinite(ink.sizes.crest))
    if not measured.any():
        return None
    usual = float(np.median(ink.sizes.crest[measured]))
    return LowerInk(
        foot=np.where(measured[:, None], (ink.sides.left + ink.sides.right) / 2,
                      track.points[lower] - below.clearance * bed.normal),
        half=np.where(measured, ink.sides.width,
                      below.width) / 2,
        crest=np.where(measured, ink.sizes.crest, usual),
        sigma=np.where(measured, ink.sizes.crest_sigma, UNSEEN_SIGMA * usual))
