"""Travel: whether ink is seen where the nozzle only went from one stroke to the next."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import runs, thinned
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.samples import Samples
from bpc_perception.core.measurement.track import Track, track_along
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.measurement.view import View
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.tangents import typical_spacing
from bpc_perception.core.profile import Cause, Status

OWN_INK_PX = 2.0  # beyond the edge of a stroke, ink may still be the stroke's


def look_at_travel(view: View, path: DepositionPath, stroke: Index, shown: Flags,
                   samples: Samples, bed: Plane,
                   look: Callable[[Track, Index], Verdicts]) -> Samples:
    """Return the samples of a path with those of travel looked at.

    Where travel passes over a stroke, nothing is known of it: the ink there is the stroke's. Where
    a string of ink on travel joins a stroke, the width of that is not known: it is a JUNCTION.

    Args:
        view: the capture.
        path: N points.
        stroke: (N,) number of the stroke of each; 0 = travel.
        shown: (N,) which of them are in view, or nearly so.
        samples: of the strokes.
        bed: plane of the bed.
        look: tells whether ink is seen at an index of points (K,) of a track.
    """
    kept = np.flatnonzero(shown)
    number = stroke[kept]
    travel, laid = np.flatnonzero(number == 0), np.flatnonzero(number > 0)
    if not len(travel) or not len(laid):
        return samples
    part = _lowered(path.where(shown), laid, bed)
    # Each travel is a way of its own.
    number = np.where(number == 0, -1 - runs(number)[0], number)
    track = track_along(part, number, np.arange(len(kept)))
    pixel = view.pixel_size(track.points)
    asked = travel[thinned(number[travel], max(1, round(pixel / typical_spacing(track.points))))]
    if len(asked) < 2:
        return samples
    found = look(track, asked).of(np.minimum(np.searchsorted(asked, travel), len(asked) - 1))
    status = found.status
    own = samples.of(kept[laid])
    ways = _Ways(bed.coordinates(part.points), own, laid, travel, OWN_INK_PX * pixel)
    string = ways.strings(status == Status.OOZE, number[travel], ~ways.over)
    # A string that is thinner than a pixel is neither ink nor bed, but takes the edge with it.
    doubtful = ways.strings(np.isin(status, (Status.OOZE, Status.LOW_CONFIDENCE)), number[travel],
                            ways.within)
    joined = ways.joined_by(string | doubtful) & (own.status == Status.MEASURED)
    found = found.where(ways.over & (status == Status.OOZE) & ~string, Status.NO_DATA,
                        Cause.OVER_STROKE)
    at_string = kept[laid[joined]]
    return replace(samples, verdicts=samples.verdicts.with_part(
        at_string, Verdicts.all_of(len(at_string), Status.JUNCTION)).with_part(
            kept[travel], found))


def _lowered(path: DepositionPath, laid: Index, bed: Plane) -> DepositionPath:
    """Return the path with all of it as high above the bed as its strokes (S,) usually are."""
    height = bed.height(path.points)
    lift = height - np.median(height[laid])
    lift[laid] = 0.0
    return path.moved_to(path.points - lift[:, None] * bed.normal)


class _Ways:
    """T points of travel beside S points of strokes.

    Attributes:
        over: (T,) whether each lies on the ink of a stroke, as wide as strokes usually are, or
            within a margin.
        within: (T,) whether each lies clearly outside of a usual stroke, but inside of its edge.
    """

    def __init__(self, places: Array, strokes: Samples, laid: Index, travel: Index,
                 margin: float) -> None:
        """Find what lies near to what.

        Args:
            places: (N, 2) of the path points on the bed [m].
            strokes: (S,) samples.
            laid: (S,) index of the points of strokes.
            travel: (T,) index of those of travel.
            margin: beyond the edge of a stroke [m].
        """
        half = np.fmax(strokes.sides.left_distance, strokes.sides.right_distance)
        usual = np.nanmedian(half) if np.isfinite(half).any() else 0.0
        self._half = np.where(np.isfinite(half), half, usual)
        self._reach = usual + margin
        self._strokes, self._margin = places[laid], margin
        self._travel = places[travel]
        self._distance, self._near = cKDTree(self._strokes).query(self._travel)
        self.over: Flags = self._distance <= np.fmin(self._half[self._near] + margin,
                                                     self._reach)
        self.within: Flags = (self._distance > self._reach - margin / 2) & (
            self._distance <= self._half[self._near])

    def strings(self, inked: Flags, way: Index, sure: Flags) -> Flags:
        """Return which points of travel (T,) lie on a string of ink.

        That is ink all along the travel from where it lies beside the strokes. Ink on strokes
        alone is theirs.

        Args:
            inked: (T,) whether there is ink.
            way: (T,) number of the travel.
            sure: (T,) where ink is no stroke's.
        """
        first, end = runs(2 * way + inked)
        beside = np.concatenate(([0], np.cumsum(inked & sure)))
        return np.asarray(inked & (beside[end] > beside[first]) & (
            self._distance > self._reach - 2 * self._margin))

    def joined_by(self, string: Flags) -> Flags:
        """Return which points of strokes (S,) have an edge that a string (T,) is part of."""
        touching = string & (self._distance <= self._half[self._near] + self._margin)
        joined = np.zeros(len(self._strokes), bool)
        if touching.any():
            joined[self._near[touching]] = True
            distance, _ = cKDTree(self._strokes[joined]).query(self._strokes)
            joined |= distance <= self._reach
        return joined


def as_travel(verdicts: Verdicts) -> Verdicts:
    """Return what verdicts on strokes mean on travel: ink is ooze, and a gap is none."""
    return verdicts.where(verdicts.status == Status.MEASURED, Status.OOZE).where(
        verdicts.status == Status.GAP, Status.BARE)
