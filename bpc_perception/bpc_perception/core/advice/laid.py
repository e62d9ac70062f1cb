"""What a path says of the ink that was commanded along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.advice.delivery_filter import (
    DEAD_TIME_S,
    DEAD_TIME_SIGMA_S,
    kept_after,
    LAGS_S,
)
from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.path.deposition_path import DepositionPath

# After each start but the first, ink is on its way for this long, known only roughly,
START_S = DEAD_TIME_S + 2 * DEAD_TIME_SIGMA_S
# and the smoothed path is slower than a nozzle that leaves or arrives.
LEAVING_S = 0.15
LONGEST_STEP_S = 0.05  # between two points; if it takes longer, the nozzle stands
DART, DART_S = 2.0, 0.5  # faster than in so long before and after, by this factor
HOLE = 2.5  # steps between path points longer than usual by this factor: poses are missing
# Path points, and time, to either side over which speed and volume per length are taken: a pose
# may be off, or late, by a few hundredths of a second.
REACH, REACH_S = 3, 0.18
# What may stand for the command, the better first.
RATES = ('flow_rate', 'plunger_velocity')


@dataclass(frozen=True)
class Laid:
    """The command at each of N path points, and what it lays.

    Attributes:
        rate: (N,) commanded, 0 where no ink was to be pushed out, NaN where the extruder's state
            is unknown though it once was not.
        speed: (N,) of the nozzle [m/s].
        volume: (N,) commanded per length of path.
        arrived: (N, L) what arrives per length of path, behind each lag.
        length: (N,) arc length without pauses, in which no ink was to be pushed out [m].
        laying: (N,) whether ink was to be laid all around each point.
        steady: (N,) whether the nozzle neither left nor arrived and its way is known all around,
            so that speed and volume hold.
        under_way: (N,) whether it had moved for so long that the dead time does not matter.
    """

    rate: Array
    speed: Array
    volume: Array
    arrived: Array
    length: Array
    laying: Flags
    steady: Flags
    under_way: Flags


def recorded_rate(path: DepositionPath) -> str:
    """Return which rate of the path tells the command; empty = none was recorded."""
    return next((name for name in RATES if (getattr(path, name)[path.extruding] > 0).any()), '')


def commanded_rates(path: DepositionPath, name: str) -> Array:
    """Return the rate (N,) commanded: a recorded one by its name, or else 1 where ink flows.

    It is 0 where no ink was to be pushed out, and NaN where the extruder's state is unknown, or
    contradicts itself: it pushes, at no rate.
    """
    if not name:
        return path.extruding.astype(float)
    rate = getattr(path, name)
    return np.where(path.extruding, np.where(rate > 0, rate, np.nan),
                    np.where(np.isnan(rate), np.nan, 0))


def held_rates(rate: Array) -> Array:
    """Return rates (N,) in which what is not known goes on as it was.

    Silence is no reason to make up for anything.
    """
    known_at = np.maximum.accumulate(np.where(np.isnan(rate), 0, np.arange(len(rate))))
    return np.nan_to_num(rate[known_at])


def flow_behind_lags(path: DepositionPath, held: Array, known: Array,
                     under_way: bool = False) -> Array:
    """Return the flow (N, L) behind each lag at each path point.

    Args:
        path: N points.
        held: (N,) rate commanded.
        known: (K, L) flow at the first points, from before.
        under_way: whether ink arrives at the first point as commanded; else nothing does.
    """
    count = len(path)
    flow = np.zeros((count, len(LAGS_S)))
    flow[:len(known)] = known
    first = max(len(known), 1)
    begin = held[0] if under_way else 0.0
    if not len(known):
        flow[0] = begin
    before = np.searchsorted(path.time, path.time - DEAD_TIME_S, side='right') - 1
    arriving = np.where(before < 0, begin, held[before])
    kept = kept_after(np.diff(path.time[first - 1:]))
    for index, share in enumerate(kept, first):
        flow[index] = arriving[index] + share * (flow[index - 1] - arriving[index])
    return flow


def laid_along(path: DepositionPath, rate: Array, held: Array, flow: Array,
               until: float) -> Laid:
    """Return what is laid along a path of N points.

    Args:
        path: N points.
        rate: (N,) commanded.
        held: (N,) the same without unknown ones.
        flow: (N, L) behind each lag.
        until: time up to which nothing is missing [s].
    """
    elapsed = np.diff(path.time, prepend=path.time[:1])
    volume = per_length(path, np.cumsum(np.concatenate((held[:1], held[:-1])) * elapsed))
    between = (flow + np.concatenate((flow[:1], flow[:-1]))) / 2
    arrived = per_length(path, np.cumsum(between * elapsed[:, None], axis=0))
    pushing = rate > 0
    moved = np.cumsum(np.minimum(elapsed, LONGEST_STEP_S))  # for how long the nozzle has
    since = _since_restart(moved, pushing)
    stands = until - path.time[-1] > max(LONGEST_STEP_S, 3 * elapsed[-REACH:].max())
    left = _until_stop(moved, pushing, stands)
    laying = _all_around(path, pushing) & (volume > 0) & np.isfinite(volume)
    return Laid(rate, per_length(path, path.arc_length, path.time), volume, arrived,
                _without_pauses(path.arc_length, rate), laying,
                _all_around(path, _way_known(path))
                & (np.minimum(since, left) > LEAVING_S), since > START_S)


def per_length(path: DepositionPath, amount: Array, length: Array | None = None) -> Array:
    """Return how much an amount (N, ...) grows per length, around each path point.

    ``length`` (N,) is the arc length unless another is given.
    """
    length = path.arc_length if length is None else length
    before, after = _around(path, REACH)
    span = length[after] - length[before]
    with np.errstate(divide='ignore', invalid='ignore'):
        return np.asarray(((amount[after] - amount[before]).T / span).T)


def _around(path: DepositionPath, reach: int) -> tuple[Index, Index]:
    """Return first and last point (N,) around each, so many points or ``REACH_S`` away."""
    index, time = np.arange(len(path)), path.time
    before = np.searchsorted(time, time - REACH_S)
    after = np.searchsorted(time, time + REACH_S, side='right') - 1
    return (np.minimum(before, np.maximum(index - reach, 0)),
            np.maximum(after, np.minimum(index + reach, len(path) - 1)))


def _all_around(path: DepositionPath, true: Flags) -> Flags:
    """Return where (N,) something is true of all points around, such as that ink is pushed out.

    That is farther than ``REACH``: the robot may leave before the extruder's last state is over.
    """
    first, last = _around(path, 2 * REACH)
    others = np.cumsum(np.concatenate(([False], ~true)))
    return np.asarray(others[last + 1] == others[first])


def _way_known(path: DepositionPath) -> Flags:
    """Return to which points (N,) the way is known, and how fast the nozzle went.

    Ink was laid in a hole as well, but on which way? And a nozzle that lays ink does not dart:
    poses come again with new stamps, or their clock was set.
    """
    arc, time = path.arc_length, path.time
    step, elapsed = (np.diff(values, prepend=values[:1]) for values in (arc, time))
    before = np.searchsorted(time, time - DART_S)
    after = np.searchsorted(time, time + DART_S, side='right') - 1
    # By time, not by points: those of a dart are many.
    usual = (arc[after] - arc[before]) / np.maximum(time[after] - time[before], DART_S)
    return np.asarray((step <= HOLE * np.median(step)) & (step <= DART * usual * elapsed))


def _since_restart(moved: Array, pushing: Flags) -> Array:
    """Return how long (N,) the nozzle has moved since ink was switched on after a pause [s].

    Before the first pause it is inf: how a print begins is told by what it was set up for, how it
    goes on is not.
    """
    begins = pushing & ~np.concatenate(([False], pushing[:-1]))
    since = np.maximum.accumulate(np.where(begins, moved, -np.inf))
    return np.where(np.cumsum(begins) > 1, moved - since, np.inf)


def _until_stop(moved: Array, pushing: Flags, stands: bool) -> Array:
    """Return how long (N,) the nozzle moves until ink is switched off [s]; inf = not yet known.

    Where a nozzle stands that pushed until there, it is switched off, or about to be.
    """
    ends = pushing & ~np.concatenate((pushing[1:], [not stands]))
    until = np.minimum.accumulate(np.where(ends, moved, np.inf)[::-1])[::-1]
    return np.asarray(until - moved)


def _without_pauses(arc: Array, rate: Array) -> Array:
    """Return arc lengths (N,) [m] that do not grow while ink is switched off after a start."""
    off = (rate == 0) & (np.cumsum(rate > 0) > 0)
    return arc - np.cumsum(np.where(off, np.diff(arc, prepend=arc[:1]), 0.0))
