"""What a finished layer, or print, says of the ink along its path."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.advice.laid import commanded_rates, held_rates, recorded_rate
from bpc_perception.core.advice.observations import GAP_MARGIN_M
from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import near_any, places_of, runs
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets

TIME_STEP_S = 0.02  # between the times at which commands are looked at
HALF = 0.5  # of the wanted width: where a bead begins and ends
LEAST_POINTS = 10
SAME_PATH_M = 1e-3  # between the middles of strokes
LONGEST_OOZE_M = 0.01


@dataclass(frozen=True)
class LayerRecord:
    """N points of a layer's path, and what was measured there.

    Attributes:
        print_id: of the print.
        layer: number of the layer within it.
        time: (N,) when the nozzle passed [s after the print's start].
        place: (N,) arc length from the layer's first ink on [m].
        points: (N, 3) of the nozzle tip in the base frame [m].
        rate: (N,) commanded; 0 on travel, NaN where not known.
        wanted: (N,) width [m].
        width: (N,) as measured [m]; 0 = no ink is there, NaN = not measured.
        ooze: (N,) whether ink is seen on travel.
        lead: how long before the first point its command was in force, while the nozzle stood [s].
    """

    print_id: str
    layer: int
    time: Array
    place: Array
    points: Array
    rate: Array
    wanted: Array
    width: Array
    ooze: Flags
    lead: float = 0.0

    @classmethod
    def of(cls, path: DepositionPath, profile: ThicknessProfile, targets: WidthTargets,
           layer: int = 0) -> LayerRecord | None:
        """Return the record of a layer; None where its command was not recorded.

        Args:
            path: of the print.
            profile: the newest of the print.
            targets: widths wanted along the print.
            layer: which of its layers.
        """
        inside = _points_of(path, profile, layer)
        path = path.where(inside)
        name = recorded_rate(path)
        if not name or path.extruding.sum() < LEAST_POINTS:
            return None
        row = places_of(profile.time, path.time)
        status = np.where(row < 0, Status.NO_DATA, profile.status[row])
        measured = status == Status.MEASURED
        bare = (status == Status.GAP) | (status == Status.BARE)
        return cls(path.print_id, layer, path.time,
                   path.arc_length - path.arc_length[np.argmax(path.extruding)], path.points,
                   commanded_rates(path, name), targets.at(path.arc_length),
                   np.where(measured, profile.thickness[row], np.where(bare, 0.0, np.nan)),
                   status == Status.OOZE)

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def strokes(self) -> Index:
        """First point (S, 2) of each stroke, and the first behind it."""
        pushing = (np.nan_to_num(self.rate) > 0).astype(np.intp)
        first, end = runs(pushing)
        begins = np.unique(first[pushing > 0])
        return np.column_stack((begins, end[begins]))

    @cached_property
    def speed(self) -> Array:
        """Speed (N,) of the nozzle [m/s]."""
        return np.gradient(self.place, self.time)

    @cached_property
    def usable(self) -> Flags:
        """Whether each point (N,) has a width that tells how much ink arrived."""
        near = near_any(self.place, self.place[self.width == 0], GAP_MARGIN_M)
        return np.asarray((self.width > 0) & (self.rate > 0) & ~near)

    @property
    def coverage(self) -> float:
        """Share of the points with ink commanded whose width is known, or that are a gap."""
        pushing = np.nan_to_num(self.rate) > 0
        return float(np.isfinite(self.width[pushing]).mean()) if pushing.any() else 0.0

    @cached_property
    def clock(self) -> Array:
        """Evenly spaced times (K,) over the layer [s]."""
        start = self.time[0] - self.lead
        count = int((self.time[-1] - start) / TIME_STEP_S) + 2
        return np.asarray(start + TIME_STEP_S * np.arange(count))

    @cached_property
    def command(self) -> Array:
        """Command (K,) at the times of the clock."""
        held = held_rates(self.rate)
        step = np.searchsorted(self.time, self.clock, side='right') - 1
        return np.asarray(held[np.clip(step, 0, len(held) - 1)])

    def aligned(self, first: LayerRecord) -> LayerRecord | None:
        """Return the record with the places of another of the same path; None if it is another.

        Layers lie above each other, and the extruder may be switched on earlier or later. So only
        the horizontal place counts.
        """
        middle = self._middles()
        if len(middle) != len(first.strokes):
            return None
        away, nearest = cKDTree(first.points[:, :2]).query(self.points[middle, :2])
        if away.max() > SAME_PATH_M:
            return None
        shift = np.median(first.place[nearest] - self.place[middle])
        return replace(self, place=self.place + shift)

    def _middles(self) -> Index:
        """Return the points (S,) in the middle of each stroke."""
        place = self.place
        return np.array([np.searchsorted(place, (place[first] + place[end - 1]) / 2)
                         for first, end in self.strokes])

    def late_begins(self, strokes: Array) -> Array:
        """Return how late (S,) each bead begins [s]; negative = early, NaN = not seen.

        It begins where it is half as wide as wanted, or where ink is seen on the travel before.

        Args:
            strokes: (S, 2) places between which ink is wanted [m].
        """
        return np.array([self._late(begin, end, 1) for begin, end in strokes])

    def late_ends(self, strokes: Array) -> Array:
        """Return how late (S,) each bead ends [s], likewise."""
        return np.array([self._late(end, begin, -1) for begin, end in strokes])

    def _late(self, at: float, other: float, inward: int) -> float:
        """Return how late the bead crosses half its width at the end of a stroke.

        Args:
            at: the place of that end [m].
            other: that of the other end [m].
            inward: 1 if the stroke lies behind the place, -1 if before.
        """
        order = np.arange(len(self))[::inward]
        away = inward * (self.place[order] - at)
        inside = order[(away >= 0) & (away <= abs(other - at))]
        outside = order[(away < 0) & (away >= -LONGEST_OOZE_M)][::-1]
        if not len(inside):
            return np.nan
        switched = np.interp(at, self.place, self.time)
        wide = np.where(np.isnan(self.width), np.where(self.ooze, 1, -1),
                        self.width >= HALF * self.wanted)[inside]
        first = int(np.argmax(wide == 1))
        if wide[first] != 1 or (first > 0 and wide[first - 1] != 0):
            return np.nan
        if first > 0:
            crossed = (self.time[inside[first]] + self.time[inside[first - 1]]) / 2
        else:
            ooze = self.ooze[outside]
            run = int(np.argmin(ooze)) if not ooze.all() else len(ooze)
            crossed = self.time[outside[run - 1]] if run else switched
        return float(crossed - switched)


def _points_of(path: DepositionPath, profile: ThicknessProfile, layer: int) -> Flags:
    """Return which path points (N,) are of a layer, with the travel within it."""
    mine = np.flatnonzero(profile.layer == layer)
    if not len(mine):
        return np.zeros(len(path), bool)
    first, last = profile.time[mine[0]], profile.time[mine[-1]]
    later = profile.time[(profile.time > last) & (profile.layer > layer)]
    end = later[0] if len(later) else np.inf
    return np.asarray((path.time >= first) & (path.time < end))
