"""A print laid flat: its path, the sides of its beads, and what is known of each sample."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from scipy.signal import savgol_filter

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import runs
from bpc_perception.core.geometry import unit_vectors
from bpc_perception.core.path.tangents import smoothed_tangents, typical_spacing
from bpc_perception.core.profile import Status, StatusArray, ThicknessProfile

STEEPEST = np.sin(np.radians(10))  # of the bed against the plane: areas are 1.5 % wrong there
TANGENT_M = 1e-3  # of path, that tells its direction, as where widths are measured
# Noise makes an edge longer than it is, and a pore less round. So edges are smoothed along so much
# of the path, or along a width where that is less; a bend that is longer stays.
SMOOTH_M = 1e-3
PARABOLA = 3  # samples that a parabola always fits
LONGEST_JUNCTION = 4.0  # widths, across which a strand's outline is interpolated


class Outline(IntEnum):
    """What is known of the outline of a bead at a sample."""

    MEASURED = 0
    INTERPOLATED = 1
    BARE = 2
    UNKNOWN = 3


@dataclass(frozen=True)
class FlatPrint:
    """N samples of strokes in the plane of the bed.

    Attributes:
        index: (N,) of the samples in the profile.
        stroke, layer: (N,) as in the profile.
        arc_length: (N,) [m].
        points: (N, 2) the path [m].
        ahead: (N, 2) unit vectors along the path.
        left, right: (N,) distance from the path to the sides [m], interpolated where not measured.
        edges: (2, N) the same, smoothed.
        sigma: (N,) 1-sigma uncertainty of the width [m], the same.
        outline: (N,) values of Outline.
        spacing: of the samples along the path [m].
        width: median width [m]; NaN without any.
        origin: (3,) of the plane, which is that of the path's lowest layer, in the base frame [m].
        axes: (2, 3) of the plane in the base frame, unit vectors.
        curved: whether the bed is too far from a plane for areas to be right.
    """

    index: Index
    stroke: Index
    layer: Index
    arc_length: Array
    points: Array
    ahead: Array
    left: Array
    right: Array
    edges: Array
    sigma: Array
    outline: Index
    spacing: float
    width: float
    origin: Array
    axes: Array
    curved: bool

    @property
    def known(self) -> Flags:
        """Where (N,) the outline is measured or interpolated."""
        return self.outline <= Outline.INTERPOLATED

    def where(self, kept: Flags) -> FlatPrint:
        """Return the print with only these samples (N,)."""
        return replace(
            self, index=self.index[kept], stroke=self.stroke[kept], layer=self.layer[kept],
            arc_length=self.arc_length[kept], points=self.points[kept], ahead=self.ahead[kept],
            left=self.left[kept], right=self.right[kept], edges=self.edges[:, kept],
            sigma=self.sigma[kept], outline=self.outline[kept])

    def sides(self, errors: Array | float = 0.0) -> tuple[Array, Array]:
        """Return the left and the right sides (N, 2) of the beads, smoothed [m].

        Args:
            errors: (2, N) how much farther out they lie than measured [m].
        """
        lateral = np.stack((-self.ahead[:, 1], self.ahead[:, 0]), axis=1)
        left, right = self.edges + errors
        return self.points + left[:, None] * lateral, self.points - right[:, None] * lateral

    def in_base(self, places: Array) -> Array:
        """Return places (K, 2) of the plane in the base frame (K, 3) [m]."""
        return np.asarray(self.origin + places @ self.axes)


def lay_flat(profile: ThicknessProfile) -> FlatPrint:
    """Return the strokes of a profile in the plane that fits the path of its lowest layer."""
    index = np.flatnonzero(profile.stroke > 0)
    stroke, layer, arc = profile.stroke[index], profile.layer[index], profile.arc_length[index]
    measured = profile.status[index] == Status.MEASURED
    way = smoothed_tangents(profile.points[index], stroke, np.arange(len(index)), TANGENT_M)
    origin, axes = _plane(profile.points[index][layer == layer.min(initial=0)], way)
    normal = np.cross(axes[0], axes[1])
    between = (profile.left_points - profile.right_points)[index]
    if np.nansum(np.cross(way, between) @ normal) < 0 or (
            not np.isfinite(between).any() and normal[2] < 0):
        axes = axes * ((1,), (-1,))
    ahead = unit_vectors(way @ axes.T)
    left, right, sigma = (_filled(values[index], measured, arc, stroke) for values in (
        profile.left, profile.right, profile.sigma))
    points = (profile.points[index] - origin) @ axes.T
    width = float(np.median(profile.thickness[index][measured])) if measured.any() else np.nan
    spacing = typical_spacing(points) if len(points) > 1 else np.nan
    edges = np.stack((left, right))
    if np.isfinite(width):
        edges = _smoothed(edges, stroke, round(min(SMOOTH_M, width) / spacing))
    outline = outlines(profile.status[index], stroke, arc, width)
    if len(points) > 1:
        points = _with_ends(points, ahead, stroke, outline, spacing)
    return FlatPrint(
        index=index, stroke=stroke, layer=layer, arc_length=arc, points=points, ahead=ahead,
        left=left, right=right, edges=edges, sigma=sigma, outline=outline, spacing=spacing,
        width=width, origin=origin, axes=axes,
        curved=bool((np.abs(way @ normal) > STEEPEST).any()))


def outlines(status: StatusArray, stroke: Index, arc_length: Array, width: float) -> Index:
    """Return what is known of the outline at each sample (N,), values of Outline.

    A JUNCTION, and a single sample without an answer, is interpolated where the same stroke is
    measured on both sides of it. A JUNCTION at an end of the stroke, which lies in ink of
    another, is taken to be as wide as the strand is beside it.

    Args:
        status: (N,) values of Status.
        stroke: (N,) number of the stroke.
        arc_length: (N,) [m].
        width: typical one of a bead [m].
    """
    found = np.full(len(status), int(Outline.UNKNOWN))
    found[status == Status.GAP] = Outline.BARE
    measured = status == Status.MEASURED
    found[measured] = Outline.MEASURED
    first, end = runs(2 * stroke + (found == Outline.UNKNOWN))
    for one, two in sorted({*zip(first.tolist(), end.tolist(), strict=True)}):
        if found[one] != Outline.UNKNOWN:
            continue
        beside = [here for here in (one - 1, two)
                  if 0 <= here < len(status) and stroke[here] == stroke[one]]
        longest = LONGEST_JUNCTION * width * len(beside) / 2
        if beside and measured[beside].all() and (
                (len(beside) == 2 and two - one == 1)
                or _is_junction(status[one:two], arc_length[one:two], longest)):
            found[one:two] = Outline.INTERPOLATED
    return found


def _is_junction(status: StatusArray, arc_length: Array, longest: float) -> bool:
    """Return whether a run of samples is a crossing, and not too long for one [m].

    A single sample on either side of it may have no answer.
    """
    junction = status == Status.JUNCTION
    return bool(junction.any() and junction[1:-1].all() and np.ptp(arc_length) <= longest)


def _with_ends(points: Array, ahead: Array, stroke: Index, outline: Index,
               spacing: float) -> Array:
    """Return a path (N, 2) whose ends in ink of others lie a sample farther out.

    Between two samples nobody knows where a stroke ends, but there is ink up to the other.
    """
    border = np.flatnonzero(np.diff(stroke))
    moved = points.copy()
    for ends, sign in ((np.append(0, border + 1), -1), (np.append(border, len(stroke) - 1), 1)):
        inside = ends[outline[ends] == Outline.INTERPOLATED]
        moved[inside] += sign * spacing * ahead[inside]
    return moved


def _plane(path: Array, way: Array) -> tuple[Array, Array]:
    """Return origin (3,) and axes (2, 3) of the plane of a path (P, 3), the first along its start.

    Args:
        path: what it is to fit [m].
        way: (N, 3) unit vectors along the whole path.
    """
    if len(path) < 2:
        return np.zeros(3), np.eye(3)[:2]
    origin = path.mean(axis=0)
    # A straight line lies in many planes; that which is most level is taken.
    level = 1e-12 * np.diag((0.0, 0.0, -1.0))
    normal = np.linalg.eigh((path - origin).T @ (path - origin) + level)[1][:, 0]
    along = way[0] - (way[0] @ normal) * normal
    along = along / np.linalg.norm(along)
    return origin, np.stack((along, np.cross(normal, along)))


def _filled(values: Array, measured: Flags, arc_length: Array, stroke: Index) -> Array:
    """Return values (N,), where not measured linear between those around in the same stroke.

    In a stroke without any it is the median of the others.
    """
    filled = np.where(measured, values, np.median(values[measured]) if measured.any() else np.nan)
    for number in np.unique(stroke):
        own = stroke == number
        told = own & measured
        if told.any():
            filled[own] = np.interp(arc_length[own], arc_length[told], values[told])
    return filled


def _smoothed(values: Array, stroke: Index, window: int) -> Array:
    """Return values (K, N) smoothed by a parabola through so many samples of each stroke (N,)."""
    smooth = values.copy()
    for number in np.unique(stroke):
        own = np.flatnonzero(stroke == number)
        length = min(window, len(own))
        length -= 1 - length % 2
        if length > PARABOLA:
            smooth[:, own] = savgol_filter(values[:, own], length, 2)
    return smooth
