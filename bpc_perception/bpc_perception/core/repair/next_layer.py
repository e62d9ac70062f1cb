"""Whether the next layer can be laid: gaps it cannot span, ink too high or too low, and doubt."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.config import RepairConfig, ToleranceConfig
from bpc_perception.core.inspection.defects import SURE_SIGMAS
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.repair.plan import FORBIDS, LayerState, NextLayer, Obstacle


@dataclass(frozen=True)
class _Runs:
    """R runs of samples.

    Attributes:
        layer: (R,) in which each lies.
        length: (R,) [m].
        count: (R,) of samples.
    """

    layer: Index
    length: Array
    count: Index

    def longest(self, layer: int) -> float:
        """Return the length of the longest in a layer [m]."""
        return float(self.length[self.layer == layer].max(initial=0.0))


def layer_states(profile: ThicknessProfile, tolerance: ToleranceConfig, config: RepairConfig,
                 contradiction: bool) -> Iterator[tuple[int, LayerState]]:
    """Yield the number of each layer, from the bed upward, and how the next one finds it.

    Args:
        profile: N samples.
        tolerance: its height wanted, and how much of a layer has to be seen.
        config: what hinders the next layer.
        contradiction: whether path and picture, or extruder and motion, do not fit.
    """
    status, layers = profile.status, profile.layer
    laid = (profile.stroke > 0) & (status != Status.JUNCTION)
    seen = np.isin(status, (Status.MEASURED, Status.GAP))
    height, room = _usual(profile, tolerance.target_height)
    doubt = SURE_SIGMAS * profile.height_sigma
    inked = status == Status.MEASURED
    with np.errstate(invalid='ignore'):
        high = inked & (profile.height - height - doubt > config.highest * room)
        low = inked & (profile.height + doubt < config.lowest * height)
    gaps, unseen, high_runs, low_runs = (
        _runs(profile, flags) for flags in (profile.missing, laid & ~seen, high, low))
    for number in np.unique(layers[layers >= 0]).tolist():
        own = layers == number
        share = float(seen[own & laid].mean()) if (own & laid).any() else np.nan
        heights = profile.height[own & inked]
        known = heights[np.isfinite(heights)]
        tall = high_runs.count[high_runs.layer == number].max(initial=0)
        found = {
            Obstacle.GAP: gaps.longest(number) > config.bridged_length,
            Obstacle.HIGH: tall >= tolerance.samples,
            Obstacle.LOW: low_runs.longest(number) > config.bridged_length,
            Obstacle.NOT_ENOUGH_SEEN: not share >= tolerance.coverage
            or unseen.longest(number) > config.bridged_length,
            Obstacle.HEIGHT_NOT_KNOWN: len(known) < max(tolerance.coverage * len(heights), 1)}
        if contradiction:
            found = {Obstacle.CONTRADICTION: True}
        yield number, LayerState(
            *_answer(tuple(each for each, there in found.items() if there)), share,
            gaps.longest(number), unseen.longest(number),
            float(height[own][0]), float(known.max()) if len(known) else np.nan,
            float(known.min()) if len(known) else np.nan)


def _answer(obstacles: tuple[Obstacle, ...]) -> tuple[NextLayer, tuple[Obstacle, ...]]:
    if FORBIDS.intersection(obstacles):
        return NextLayer.NO, obstacles
    return (NextLayer.NOT_KNOWN if obstacles else NextLayer.YES), obstacles


def _usual(profile: ThicknessProfile, wanted: float) -> tuple[Array, Array]:
    """Return the height of the layer of each sample (N,), and the room below the nozzle [m].

    The next layer is laid a layer's height above this one, so that its nozzle has the same room
    above ink of the usual height. A bead is hardly higher than the nozzle that laid it: where the
    room is less than the height, nozzle offset or bed are not known so well.
    """
    height, room = np.full(len(profile), np.nan), np.full(len(profile), np.nan)
    above = np.linalg.norm(profile.points - profile.feet, axis=1)
    measured = profile.status == Status.MEASURED
    for number in np.unique(profile.layer[profile.layer >= 0]).tolist():
        own = profile.layer == number
        told = own & measured & np.isfinite(profile.height)
        height[own] = wanted or (np.median(profile.height[told]) if told.any() else np.nan)
        if (own & measured).any():
            room[own] = np.fmax(np.median(above[own & measured]), height[own])
    return height, room


def _runs(profile: ThicknessProfile, flags: Flags) -> _Runs:
    """Return the runs of True (N,) in one stroke each."""
    extents = profile.runs_of(flags)
    arc = profile.arc_length
    first = np.searchsorted(arc, extents[:, 0])
    end = np.searchsorted(arc, extents[:, 1], side='right')
    middle = np.minimum((first + end) // 2, len(arc) - 1)
    return _Runs(profile.layer[middle], extents[:, 1] - extents[:, 0], end - first)
