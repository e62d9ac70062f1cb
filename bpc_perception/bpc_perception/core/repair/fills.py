"""Strokes to fill: the way of the nozzle over what lacks ink, and what is lacking along it.

A gap wants all that was commanded there. A thin stretch wants what its cross-section lacks beside
sound ink of its layer, per volume that was commanded: so whether the flow is calibrated does not
matter. Where the borders of a stretch, its flow or its area are in doubt, nothing is proposed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.config import RepairConfig, ToleranceConfig
from bpc_perception.core.inspection.defects import (
    Defect,
    DefectKind,
    inner,
    SURE_SIGMAS,
)
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.repair.plan import Fill, FillKind, NotFilled, Unfilled
from bpc_perception.core.targets import WidthTargets

LEAST_KNOWN = 0.5  # share of the samples of a stretch whose command or area has to be known
LEAST_SOUND = 10  # samples of sound ink in a layer, to compare a thin stretch with
THIN = frozenset((DefectKind.THIN, DefectKind.NECK))
# Where one of these is, ink is not sound:
UNSOUND = THIN | {DefectKind.THICK, DefectKind.LOW, DefectKind.HIGH}


class _RefusalError(Exception):
    """A stretch is not filled; the argument tells why."""


@dataclass(frozen=True)
class _Edge:
    """Where a stretch begins or ends.

    Attributes:
        at: arc length [m].
        ink: sample of ink on which it borders; -1 = the stroke ends there, or bed goes on.
    """

    at: float
    ink: int = -1


@dataclass(frozen=True, eq=False)
class Filling:
    """Finds what is to fill in a print.

    Attributes:
        profile: N samples.
        defects: of the print.
        targets: widths wanted along the path; None = none.
        tolerance: how far it may be off.
        config: what is filled.
    """

    profile: ThicknessProfile
    defects: Sequence[Defect]
    targets: WidthTargets | None
    tolerance: ToleranceConfig
    config: RepairConfig

    def find(self, contradiction: bool) -> Iterator[Fill | Unfilled]:
        """Yield each stretch that lacks ink, with its stroke to fill or why there is none.

        Args:
            contradiction: whether path and picture, or extruder and motion, do not fit.
        """
        filled: list[Fill] = []
        for kind, extent, make in (*self._gaps(), *self._thin(filled)):
            found = self._made(kind, extent, make, contradiction)
            if isinstance(found, Fill):
                filled.append(found)
            yield found

    def _gaps(self) -> Iterator[tuple[FillKind, tuple[float, float], Callable[[], Fill]]]:
        for start, end in self.profile.gaps.tolist():
            yield FillKind.GAP, (start, end), partial(self._over_gap, start, end)

    def _thin(self, filled: Sequence[Fill]) -> Iterator[
            tuple[FillKind, tuple[float, float], Callable[[], Fill]]]:
        for each in self.defects:
            if each.kind in THIN:
                yield (FillKind.THIN, (each.start, each.end),
                       partial(self._over_thin, each.start, each.end, filled))

    def _made(self, kind: FillKind, extent: tuple[float, float], make: Callable[[], Fill],
              contradiction: bool) -> Fill | Unfilled:
        try:
            if contradiction:
                raise _RefusalError(NotFilled.CONTRADICTION)
            return make()
        except _RefusalError as refusal:
            profile, at = self.profile, self._sample(sum(extent) / 2)
            x, y, z = profile.points[at].tolist()
            return Unfilled(kind, int(profile.stroke[at]), int(profile.layer[at]), *extent,
                            (x, y, z), refusal.args[0])

    def _over_gap(self, start: float, end: float) -> Fill:
        if end - start <= self.tolerance.gap_length:
            raise _RefusalError(NotFilled.ALLOWED)
        width = self._expect_long(start, end)
        inside = self._inside(start, end)
        inside = inside[self.profile.missing[inside]]
        edges = [self._edge(int(inside[place]), step, width)
                 for place, step in ((0, -1), (-1, 1))]
        if None in edges:
            raise _RefusalError(NotFilled.END_NOT_SEEN)
        begins, ends = (edge for edge in edges if edge is not None)
        way = (self._overlap(begins, -1, width), self._overlap(ends, 1, width))
        return self._fill(FillKind.GAP, (begins.at, ends.at), way,
                          self._commanded(begins.at, ends.at))

    def _over_thin(self, start: float, end: float, filled: Sequence[Fill]) -> Fill:
        profile = self.profile
        self._expect_long(start, end)
        inside = self._inside(start, end)
        layer = int(profile.layer[self._sample((start + end) / 2)])
        commanded, delivered = self._commanded(start, end), self._delivered.get(layer, np.nan)
        area, sigma = profile.area[inside], profile.area_sigma[inside]
        known = np.isfinite(area)
        if known.mean() < LEAST_KNOWN or np.isnan(delivered):
            raise _RefusalError(NotFilled.AREA_NOT_KNOWN)
        arc = profile.arc_length[inside]
        lacking = commanded(arc) - area / delivered
        doubt = SURE_SIGMAS * np.nan_to_num(sigma[known]).mean() / delivered
        if not lacking[known].mean() > doubt:
            raise _RefusalError(NotFilled.ENOUGH_INK)
        lacking = np.where(known, np.maximum(lacking, 0.0), 0.0)  # where in doubt, lay nothing
        for gap in filled:
            lacking[(arc >= gap.start) & (arc <= gap.end)] = 0.0
        return self._fill(FillKind.THIN, (start, end), (start, end),
                          lambda at: np.interp(at, arc, lacking))

    def _expect_long(self, start: float, end: float) -> float:
        """Return the width of the bead around a stretch, if it is long enough to be filled."""
        middle = self._sample((start + end) / 2)
        width = (float(self.targets.at(self.profile.arc_length[middle]))
                 if self.targets is not None else
                 self._widths.get(int(self.profile.layer[middle]), np.nan))
        if np.isnan(width):
            raise _RefusalError(NotFilled.WIDTH_NOT_KNOWN)
        if end - start < self.config.least_length * width:
            raise _RefusalError(NotFilled.SHORT)
        return width

    def _edge(self, inner: int, step: int, width: float) -> _Edge | None:
        """Return where a gap ends beyond its last sample; None = that is not seen.

        Beside the end of ink samples are doubtful: it lies half-way to the first that is not, if
        that is within a width.
        """
        profile = self.profile
        arc, status = profile.arc_length, profile.status
        at = inner + step
        while (self._goes_on(inner, at) and status[at] == Status.LOW_CONFIDENCE
               and abs(arc[at] - arc[inner]) <= width):
            at += step
        if not self._goes_on(inner, at):
            return _Edge(float(arc[inner])) if at == inner + step else None
        if status[at] == Status.MEASURED:
            return _Edge(float(arc[at] + arc[inner]) / 2, at)
        if status[at] == Status.GAP:
            return _Edge(float(arc[inner] + arc[inner + step]) / 2)
        return None

    def _overlap(self, edge: _Edge, step: int, width: float) -> float:
        """Return the arc length up to which a fill lies on the ink beside its edge."""
        if edge.ink < 0:
            return edge.at
        profile, reach = self.profile, edge.at + step * self.config.overlap * width
        at = edge.ink
        while (self._goes_on(edge.ink, at + step) and profile.status[at + step] == Status.MEASURED
               and step * (profile.arc_length[at] - reach) < 0):
            at += step
        last = float(profile.arc_length[at])
        return min(reach, last) if step > 0 else max(reach, last)

    def _goes_on(self, inner: int, at: int) -> bool:
        """Return whether a sample is there, and on the same stroke."""
        stroke = self.profile.stroke
        return 0 <= at < len(stroke) and bool(stroke[at] == stroke[inner])

    def _fill(self, kind: FillKind, extent: tuple[float, float], way: tuple[float, float],
              lacking: Callable[[Array], Array]) -> Fill:
        profile, middle = self.profile, self._sample(sum(extent) / 2)
        arc = profile.arc_length
        at = np.unique((*way, *extent, *arc[self._inside(*way)]))
        near = self._with_neighbours(*way)
        points = np.column_stack([np.interp(at, arc[near], axis)
                                  for axis in profile.points[near].T])
        if self._covered(points, middle):
            raise _RefusalError(NotFilled.COVERED)
        halfway = (at[1:] + at[:-1]) / 2
        inside = (halfway > extent[0]) & (halfway < extent[1])
        area = np.append(np.where(inside, lacking(halfway), 0.0), 0.0)
        return Fill(kind, int(profile.stroke[middle]), int(profile.layer[middle]), *extent, at,
                    points, area, self._speed(*way))

    def _speed(self, start: float, end: float) -> float:
        """Return the usual speed of the nozzle along a stretch and to the samples beside it."""
        around = self._with_neighbours(start, end)
        if around.stop - around.start < 2:
            raise _RefusalError(NotFilled.FLOW_NOT_KNOWN)
        return float(np.median(np.diff(self.profile.arc_length[around])
                               / np.diff(self.profile.time[around])))

    def _commanded(self, start: float, end: float) -> Callable[[Array], Array]:
        """Return the volume per length that was commanded, over arc length along a stretch."""
        profile, inside = self.profile, self._inside(start, end)
        told = profile.commanded_area[inside]
        known = np.isfinite(told) & (told > 0)
        if not known.mean() >= LEAST_KNOWN:
            raise _RefusalError(NotFilled.FLOW_NOT_KNOWN)
        at, area = profile.arc_length[inside][known], told[known]
        return lambda asked: np.asarray(np.interp(asked, at, area))

    def _covered(self, points: Array, middle: int) -> bool:
        """Return whether the nozzle would touch ink of a higher layer on its way (K, 3)."""
        layer = int(self.profile.layer[middle])
        if layer not in self._above:
            self._above[layer] = self._seen_from_above(layer)
        flat, above = self._above[layer]
        way = points @ flat
        reach = self.config.nozzle_radius + np.nanmax([*self._widths.values(), 0.0]) / 2
        first, end = np.searchsorted(above[:, 0], (way[:, 0].min() - reach,
                                                   way[:, 0].max() + reach))
        if first == end:
            return False
        away, _ = cKDTree(above[first:end]).query(way, distance_upper_bound=reach)
        return bool(np.isfinite(away).any())

    def _seen_from_above(self, layer: int) -> tuple[Array, Array]:
        """Return what lays points flat as seen along the nozzle, and higher layers (M, 3) so.

        These are in the order of x, by which those near a place are found fast.
        The nozzle points from its tip to the surface below, as in most of the layer.
        """
        profile = self.profile
        own = profile.layer == layer
        down = np.median(profile.feet[own] - profile.points[own], axis=0)
        length = np.linalg.norm(down)
        down = down / length if length > 0 else down
        flat = np.eye(3) - np.outer(down, down)
        above = profile.points[profile.layer > layer] @ flat
        return flat, above[np.argsort(above[:, 0])]

    def _with_neighbours(self, start: float, end: float) -> slice:
        """Return the samples of a stretch of a stroke, and those beside it on the stroke."""
        own = self._inside(start, end)
        first, last = (at + step if self._goes_on(at, at + step) else at
                       for at, step in ((int(own[0]), -1), (int(own[-1]), 1)))
        return slice(first, last + 1)

    def _inside(self, start: float, end: float) -> Index:
        """Return the samples of a stretch of a stroke."""
        arc = self.profile.arc_length
        return np.arange(np.searchsorted(arc, start), np.searchsorted(arc, end, side='right'))

    def _sample(self, arc_length: float) -> int:
        """Return the sample nearest to an arc length [m]."""
        arc = self.profile.arc_length
        after = int(np.clip(np.searchsorted(arc, arc_length), 1, len(arc) - 1))
        return after - int(arc_length - arc[after - 1] < arc[after] - arc_length)

    @cached_property
    def _above(self) -> dict[int, tuple[Array, Array]]:
        """What lies above each layer, as far as it was asked for."""
        return {}

    @cached_property
    def _widths(self) -> dict[int, float]:
        """The median width of each layer [m]."""
        profile = self.profile
        return {layer: float(np.median(profile.thickness[own])) for layer, own in self._measured(
            profile.status == Status.MEASURED)}

    @cached_property
    def _delivered(self) -> dict[int, float]:
        """How much sound ink lies in each layer, per volume that was commanded."""
        profile = self.profile
        told = profile.commanded_area
        # The ends of strokes are not judged, and need not be sound.
        sound = ((profile.status == Status.MEASURED) & np.isfinite(profile.area)
                 & np.isfinite(told) & (told > 0) & inner(profile, self.tolerance.ends))
        for each in self.defects:
            if each.kind in UNSOUND:
                sound[self._inside(each.start, each.end)] = False
        return {layer: float(profile.area[own].sum() / told[own].sum())
                for layer, own in self._measured(sound) if own.sum() >= LEAST_SOUND}

    def _measured(self, chosen: Flags) -> Iterator[tuple[int, Flags]]:
        """Yield each layer that has chosen samples (N,), and these."""
        layer = self.profile.layer
        for number in np.unique(layer[chosen & (layer >= 0)]).tolist():
            yield number, chosen & (layer == number)
