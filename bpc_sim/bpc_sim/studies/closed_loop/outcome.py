"""Figures that say how near to its target a print comes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.closed_loop.model import PATH_SPACING_M, Trace
from bpc_sim.closed_loop.situation import Situation

SETTLING_LENGTH_M = 0.025  # of path, after which the deviation counts as settled
SETTLED_BEFORE_FAULT_M = 0.05  # of path, which counts even if a fault begins before
SMOOTHING_LENGTH_M = 0.005  # of path, over which the width is averaged for settling and overshoot
SETTLED_DEVIATION = 0.05  # the deviation has to be smaller ...
SETTLED_LENGTH_M = 0.02  # ... along this length of path
TOLERATED_DEVIATION = 0.1


@dataclass(frozen=True)
class Outcome:
    """Figures of one print; deviations are relative to the target.

    Attributes:
        scenario, controller, seed: the print.
        layer: number of the layer, from 1.
        rms: root of the mean square deviation over all of the path.
        rms_settled: the same from SETTLING_LENGTH_M after the event on.
        settling: path from the event until the deviation stays small [m]; NaN = never.
        overshoot: largest smoothed deviation to the other side than without feedback.
        outside: share of the path that is off by more than TOLERATED_DEVIATION.
        growth: how much more the factor varies in the last third than in the middle third.
        scale_min, scale_max: smallest and largest factor in force.
        raised: how much the factor rises after a fault, beyond nominal.
        alarm: captures from when a fault can be known until an alarm; NaN = no fault, or no
            alarm.
    """

    scenario: str
    controller: str
    seed: int
    layer: int
    rms: float
    rms_settled: float
    settling: float
    overshoot: float
    outside: float
    growth: float
    scale_min: float
    scale_max: float
    raised: float
    alarm: float


def settled_deviation(trace: Trace, print_: Situation) -> Array:
    """Return the deviations (K,) from where they should have settled to where a fault begins."""
    return trace.error[(trace.s > print_.event + SETTLING_LENGTH_M)
                       & (trace.s < max(print_.fault, SETTLED_BEFORE_FAULT_M))]


def evaluate(trace: Trace, print_: Situation, controller: str, side: float,
             layer: int = 1) -> Outcome:
    """Return the figures of a print.

    Args:
        trace: the course of the print.
        print_: what went wrong.
        controller: name of the controller.
        side: sign of the deviation without feedback.
        layer: number of the layer, from 1.
    """
    window = round(SMOOTHING_LENGTH_M / PATH_SPACING_M)
    smooth = np.convolve(trace.error, np.ones(window) / window, 'valid')
    place = trace.s[window - 1:]
    smooth, place = smooth[place >= print_.event], place[place >= print_.event]
    third = len(trace.s) // 3
    after = trace.scale[trace.s >= print_.fault]
    return Outcome(
        print_.name, controller, print_.seed, layer, rms(trace.error),
        rms(settled_deviation(trace, print_)), settling(place - print_.event, smooth),
        overshoot(smooth, side), float((np.abs(trace.error) > TOLERATED_DEVIATION).mean()),
        float(trace.scale[-third:].std() - trace.scale[third:-third].std()),
        float(trace.scale.min()), float(trace.scale.max()),
        float(after.max() / max(after[0], 1) - 1) if len(after) else np.nan,
        alarm(trace, print_) if controller.startswith('advice') else np.nan)


def rms(values: Array) -> float:
    """Return the root of the mean square of values (N,); NaN = no values."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else np.nan


def settling(place: Array, deviation: Array) -> float:
    """Return the place [m] from which on the deviation stays small for a while; NaN = nowhere.

    Places (N,) [m] and deviations (N,) belong together.
    """
    bad = np.flatnonzero(np.abs(deviation) > SETTLED_DEVIATION)
    starts = np.concatenate(([0], bad + 1))
    ends = np.concatenate((bad, [len(place)]))
    long = (ends - starts) * PATH_SPACING_M >= SETTLED_LENGTH_M
    return float(place[starts[long][0]]) if long.any() else np.nan


def overshoot(deviation: Array, side: float) -> float:
    """Return the largest deviation to the other side of deviations (N,).

    A bead that gets too thick begins thin; that beginning does not count.
    """
    if side <= 0:
        return float(max(deviation.max(), 0))
    reached = np.flatnonzero(deviation >= 0)
    return float(max(-deviation[reached[0]:].min(), 0)) if len(reached) else 0.0


def alarm(trace: Trace, print_: Situation) -> float:
    """Return the captures from the first that can show a fault to the first with an alarm."""
    until, count = 0.0, 0
    for look in trace.looks:
        known = look.visible_to if print_.fault_shows_in_bead else look.nozzle_at
        count += known > print_.fault
        if look.advice is None:
            alarmed = look.time + print_.period > until  # before the next capture is missed
        else:
            until, alarmed = look.advice.valid_until_ns * 1e-9, not look.advice.valid
        if count and alarmed:
            return float(count)
    return np.nan
