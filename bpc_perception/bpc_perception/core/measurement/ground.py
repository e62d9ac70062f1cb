"""What lay on the bed before: where ink is laid on old ink, its width is not that of the new.

Old ink is the residue of another print, or the print before under the same path. It is seen in the
capture before. Where there was none it is looked for ahead of the nozzle: ink that goes on there
was not laid by it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import runs, thinned
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.ahead import arc_ahead
from bpc_perception.core.measurement.samples import Samples
from bpc_perception.core.measurement.track import Track, track_along
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.measurement.view import View
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.tangents import typical_spacing
from bpc_perception.core.profile import Cause, Status, StatusArray

# What a capture from longer before a print shows may be another bed [s].
STILL_THE_BED_S = 10.0
# Fresh ink lies ahead of the nozzle by so many usual widths at most, and by how far it moves while
# the clocks of robot and camera may differ [s].
FRESH_WIDTHS = 1.5
CLOCKS_AGREE_S = 0.1
LEAST_M = 0.001  # of path on old ink; less is a speck
MOVING_S = 0.5  # the nozzle goes on if it moved so shortly before a capture
AHEAD_M = 0.004  # so far ahead of fresh ink it is looked for old ink,
MOST_AHEAD = 0.8  # which is there if this share of it is ink

Look = Callable[[View, Track, Index], Verdicts]


class Ground:
    """What was seen of the ground of a print.

    Attributes:
        warning: that ink was laid on old ink; empty = not as far as is known.
    """

    def __init__(self) -> None:
        self.warning = ''
        self._before: View | None = None  # the capture before
        self._print_id = ''
        self._doubted: Array = np.empty(0)  # times of path points on old ink

    def see(self, view: View) -> None:
        """Remember a capture from before a print."""
        self._before = view

    def judge(self, view: View, path: DepositionPath, stroke: Index, shown: Flags,
              samples: Samples, bed: Plane, look: Look) -> Samples:
        """Return the samples of a path with those on old ink as LOW_CONFIDENCE.

        Args:
            view: the capture.
            path: N points along the bed.
            stroke: (N,) number of the stroke of each; 0 = travel.
            shown: (N,) which of them are in view, or nearly so.
            samples: of the points.
            bed: plane of the bed.
            look: tells whether ink is seen in a view at an index of points (K,) of a track, as on
                travel.
        """
        if path.print_id != self._print_id:
            self._begin(path)
        width = samples.sides.width
        if np.isfinite(width).any():
            seen = _Seen(path.where(shown), stroke[shown], float(np.nanmedian(width)), bed, look)
            on_ink = (seen.towards_ink(view) if self._before is None
                      else seen.laid_on_ink(self._before, self._doubted))
            self._doubted = np.union1d(self._doubted, path.time[shown][on_ink])
        self._before = view
        return self.without_doubted(samples, path)

    def _begin(self, path: DepositionPath) -> None:
        self._print_id, self._doubted = path.print_id, np.empty(0)
        if self._before is not None:
            age = (path.start_ns - self._before.capture.stamp_ns) * 1e-9
            if age > STILL_THE_BED_S:
                self._before = None

    def without_doubted(self, samples: Samples, path: DepositionPath) -> Samples:
        """Return the samples of a path with those known to lie on old ink as LOW_CONFIDENCE."""
        self.warning = ''
        if path.print_id != self._print_id:
            return samples
        doubted = np.isin(path.time, self._doubted) & (samples.status == Status.MEASURED)
        if not doubted.any():
            return samples
        self.warning = ('path: expected a bed without ink where ink is laid, found that of '
                        'before; its width is not told there; clean the bed')
        return replace(samples, verdicts=samples.verdicts.where(
            doubted, Status.LOW_CONFIDENCE, Cause.OLD_INK))


class _Seen:
    """N points of a path in the views of two captures."""

    def __init__(self, path: DepositionPath, stroke: Index, width: float, bed: Plane,
                 look: Look) -> None:
        self._path, self._stroke, self._bed, self._look = path, stroke, bed, look
        speed = np.median(np.diff(path.arc_length)) / np.median(np.diff(path.time))
        self._fresh = FRESH_WIDTHS * width + CLOCKS_AGREE_S * speed

    def laid_on_ink(self, before: View, doubted: Array) -> Flags:
        """Return which points (N,) were laid since a capture, on ink that it shows.

        Args:
            before: the capture.
            doubted: times of the points before that were laid on ink.
        """
        path, on_ink = self._path, np.zeros(len(self._path), bool)
        until = (before.capture.stamp_ns - path.start_ns) * 1e-9
        new = np.flatnonzero((path.time > until) & (self._stroke > 0))
        if len(new) < 2:
            return on_ink
        inked = self._looked(before, path, self._stroke, new) == Status.OOZE
        own = path.points[(path.time <= until) & (self._stroke > 0)]
        sure = inked
        if len(own):  # near to what this print had laid the ink may be its own
            away, _ = cKDTree(self._bed.coordinates(own)).query(
                self._bed.coordinates(path.points[new]))
            sure = inked & (away > self._fresh)
            sure[0] |= inked[0] & np.isin(path.time[new[0] - 1], doubted)
        on_ink[new] = self._stretches(inked, sure, new)
        return on_ink

    def towards_ink(self, view: View) -> Flags:
        """Return the points (N,) if the nozzle goes towards ink, else none."""
        path, stroke = self._path, self._stroke
        nothing = np.zeros(len(path), bool)
        first, _ = runs(stroke)
        last = path.points[first[-1]:]
        stood = (view.capture.stamp_ns - path.start_ns) * 1e-9 - path.time[-1]
        if path.finished or stood > MOVING_S or not stroke[-1] or len(last) < 3:
            return nothing
        spacing = typical_spacing(path.points)
        distances = np.arange(self._fresh, self._fresh + AHEAD_M, spacing)
        ahead = arc_ahead(last, self._bed, distances)
        if not np.isfinite(ahead).all() or len(ahead) < 2:
            return nothing
        longer = _with_points(path, ahead, distances)
        number = np.append(stroke, np.zeros(len(ahead), stroke.dtype))
        index = np.arange(len(path), len(longer))
        status = self._looked(view, longer, number, index)
        own = path.points[stroke > 0]
        away = cKDTree(self._bed.coordinates(own)).query(
            self._bed.coordinates(ahead))[0] > self._fresh / 2
        told = np.isin(status, (Status.OOZE, Status.BARE)) & away
        inked = told & (status == Status.OOZE)
        if told.sum() * spacing < LEAST_M or inked.sum() < MOST_AHEAD * told.sum():
            return nothing
        return np.asarray(stroke > 0)

    def _looked(self, view: View, path: DepositionPath, stroke: Index,
                index: Index) -> StatusArray:
        """Return what a view shows at an index of points (K,), as on travel."""
        ways = np.where(stroke == 0, -1 - runs(stroke)[0], stroke)  # each travel one by itself
        track = track_along(path, ways, np.arange(len(path)))
        extruding = track.extruding.copy()
        extruding[index] = False  # not yet
        track = replace(track, extruding=extruding)
        step = max(1, round(view.pixel_size(path.points) / typical_spacing(path.points)))
        asked = index[thinned(track.piece[index], step)]
        status = self._look(view, track, asked).status
        return status[np.minimum(np.searchsorted(asked, index), len(asked) - 1)]

    def _stretches(self, inked: Flags, sure: Flags, index: Index) -> Flags:
        """Return the points (K,) of an index that lie on stretches of ink that are surely old."""
        piece = np.cumsum(np.append(0, np.diff(index) > 1))
        first, end = runs(2 * piece + inked)
        count = np.concatenate(([0], np.cumsum(sure)))
        arc = self._path.arc_length[index]
        return np.asarray(inked & (count[end] > count[first])
                          & (arc[end - 1] - arc[first] > LEAST_M))


def _with_points(path: DepositionPath, ahead: Array, distances: Array) -> DepositionPath:
    """Return a path with points (K, 3) added, distances (K,) [m] behind its end."""
    count = len(ahead)
    blank, no = np.full(count, np.nan), np.zeros(count, bool)
    return replace(
        path, time=np.append(path.time, path.time[-1] + 1 + np.arange(count)),
        arc_length=np.append(path.arc_length, path.arc_length[-1] + distances),
        points=np.vstack((path.points, ahead)),
        plunger_velocity=np.append(path.plunger_velocity, blank),
        flow_rate=np.append(path.flow_rate, blank), extruding=np.append(path.extruding, no),
        extruder_known=np.append(path.extruder_known, no))
