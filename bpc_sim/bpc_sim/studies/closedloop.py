"""Prints that go wrong, with and without advice: how near to the target the bead comes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.closed_loop.loop import ClosedLoop, Situation, SPACING, Trace
from bpc_sim.closed_loop.rate_control import (
    AdviceFollower,
    Controller,
    MassBalance,
    NoFeedback,
    ProportionalIntegral,
)
from bpc_sim.closed_loop.situations import situation, SITUATIONS
from bpc_sim.studies.study import Row, Study

SETTLING = 0.025  # of path, after which the deviation counts as settled [m]
SMOOTH = 0.005  # of path, over which the width is averaged for settling and overshoot [m]
SETTLED, STAYS = 0.05, 0.02  # deviation and length of path for which it has to be less [m]
TOLERANCE = 0.1

# Name in the table: actuator, and what makes the controller of a print.
CONTROLLERS: dict[str, tuple[str, Callable[[Situation], Controller]]] = {
    'none': ('flow', lambda _: NoFeedback()),
    'mass_balance': ('flow', lambda print_: MassBalance(print_.targets)),
    'pi': ('flow', lambda print_: ProportionalIntegral(print_.targets)),
    'advice': ('flow', lambda _: AdviceFollower('flow')),
    'advice_speed': ('speed', lambda _: AdviceFollower('speed')),
}


@dataclass(frozen=True)
class Outcome:
    """Figures of one print; deviations are relative to the target.

    Attributes:
        scenario, controller, seed: of the print.
        rms: deviation over all of the path.
        rms_settled: from SETTLING after the event on.
        settling: path from the event until the deviation stays small [m]; NaN = never.
        overshoot: largest deviation to the other side than without feedback, SMOOTH-ed.
        outside: share of the path that is off by more than TOLERANCE.
        growth: by how much the factor varies more in the last third than in the middle one.
        scale_min, scale_max: of the factor in force.
        raised: by how much the factor rises after a fault, beyond nominal.
        alarm: captures from when a fault can be known until an alarm; NaN = no fault, or none.
    """

    scenario: str
    controller: str
    seed: int
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


def tasks(seeds: int) -> list[tuple[str, int]]:
    """Scenario and seed."""
    return [(name, seed) for name in SITUATIONS for seed in range(seeds)]


def work(task: tuple[str, int]) -> list[Outcome]:
    """One print, under each controller."""
    print_ = situation(*task)
    traces = {name: run(print_, name) for name in CONTROLLERS}
    side = np.sign(settled(traces['none'], print_).mean())
    return [outcome(trace, print_, name, float(side)) for name, trace in traces.items()]


def run(print_: Situation, controller: str) -> Trace:
    """Print under a controller of this name."""
    actuator, make = CONTROLLERS[controller]
    return ClosedLoop(print_, make(print_), actuator).run()


def settled(trace: Trace, print_: Situation) -> Array:
    """Deviations from where they should have settled to where a fault begins."""
    return trace.error[(trace.s > print_.event + SETTLING) & (trace.s < max(print_.fault, 0.05))]


def outcome(trace: Trace, print_: Situation, controller: str, side: float) -> Outcome:
    """The figures; ``side`` is that on which the bead is without feedback."""
    window = round(SMOOTH / SPACING)
    smooth = np.convolve(trace.error, np.ones(window) / window, 'valid')
    place = trace.s[window - 1:]
    smooth, place = smooth[place >= print_.event], place[place >= print_.event]
    third = len(trace.s) // 3
    after = trace.scale[trace.s >= print_.fault]
    return Outcome(
        print_.name, controller, print_.seed, rms(trace.error), rms(settled(trace, print_)),
        settling(place - print_.event, smooth), overshoot(smooth, side),
        float((np.abs(trace.error) > TOLERANCE).mean()),
        float(trace.scale[-third:].std() - trace.scale[third:-third].std()),
        float(trace.scale.min()), float(trace.scale.max()),
        float(after.max() / max(after[0], 1) - 1) if len(after) else np.nan,
        alarm(trace, print_) if controller.startswith('advice') else np.nan)


def rms(values: Array) -> float:
    """Root of the mean square; NaN = no values."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else np.nan


def settling(place: Array, deviation: Array) -> float:
    """Where the deviation becomes and for a while stays small [m]; NaN = nowhere."""
    bad = np.flatnonzero(np.abs(deviation) > SETTLED)
    starts = np.concatenate(([0], bad + 1))
    ends = np.concatenate((bad, [len(place)]))
    long = (ends - starts) * SPACING >= STAYS
    return float(place[starts[long][0]]) if long.any() else np.nan


def overshoot(deviation: Array, side: float) -> float:
    """Largest deviation to the other side; a bead too thick begins thin, which does not count."""
    if side <= 0:
        return float(max(deviation.max(), 0))
    reached = np.flatnonzero(deviation >= 0)
    return float(max(-deviation[reached[0]:].min(), 0)) if len(reached) else 0.0


def alarm(trace: Trace, print_: Situation) -> float:
    """Captures from the first that can show a fault to the first that led to an alarm."""
    until, count = 0.0, 0
    for look in trace.looks:
        known = look.seen if print_.seen else look.arc
        count += known > print_.fault
        if look.advice is None:
            alarmed = look.time + print_.period > until  # before another is missed
        else:
            until, alarmed = look.advice.valid_until_ns * 1e-9, not look.advice.valid
        if count and alarmed:
            return float(count)
    return np.nan


def rows(found: list[list[Outcome]]) -> list[Row]:
    """A row for each scenario and controller; the seeds taken together."""
    outcomes = [one for several in found for one in several]
    table = []
    for scenario in SITUATIONS:
        none = [one for one in outcomes if (one.scenario, one.controller) == (scenario, 'none')]
        for controller in CONTROLLERS:
            mine = [one for one in outcomes
                    if (one.scenario, one.controller) == (scenario, controller)]
            if mine:
                table.append(row(mine, none))
    return table


def row(mine: list[Outcome], none: list[Outcome]) -> Row:
    """Means over the seeds, and of what has a limit the worst."""
    def every(name: str, of: list[Outcome] = mine) -> Array:
        return np.array([getattr(one, name) for one in of])

    def worst(values: Array) -> float:
        # What never happened, in one of the seeds, is worse than any number.
        return float(values.max()) if len(values) else np.nan

    ratio = every('rms_settled') / every('rms_settled', none)
    return {
        'scenario': mine[0].scenario, 'controller': mine[0].controller, 'prints': len(mine),
        'rms_percent': float(every('rms').mean()) * 100,
        'rms_ratio': float((every('rms') / every('rms', none)).mean()),
        'settled_rms_percent': float(every('rms_settled').mean()) * 100,
        'settled_rms_ratio': float(ratio.mean()), 'settled_rms_ratio_max': worst(ratio),
        'settling_mm': float(np.nanmedian(every('settling'))) * 1e3
        if np.isfinite(every('settling')).any() else np.nan,
        'settling_max_mm': worst(every('settling')) * 1e3,
        'overshoot_percent': float(every('overshoot').mean()) * 100,
        'overshoot_max_percent': worst(every('overshoot')) * 100,
        'outside_percent': float(every('outside').mean()) * 100,
        'growth_max': worst(every('growth')), 'scale_min': float(every('scale_min').min()),
        'scale_max': worst(every('scale_max')), 'raised_max': worst(every('raised')),
        'alarm_max': worst(every('alarm'))}


CLOSED_LOOP = Study('Prints that go wrong: without feedback, with the mass balance at every '
                    'capture, a PI controller on the mean width, and the advice, on flow or speed',
                    tasks, work, rows, seeds=20, processes=2)


def tune(seeds: range = range(1000, 1010)) -> list[tuple[float, float, float]]:
    """Proportional and integral gain of the PI, and its mean (rms / rms without feedback)^2.

    Best first, over the scenarios without a fault, on seeds that no study uses.
    """
    prints = [situation(name, seed) for name in SITUATIONS for seed in seeds]
    prints = [print_ for print_ in prints if np.isinf(print_.fault)]
    none = np.array([rms(run(print_, 'none').error) for print_ in prints])
    found = []
    for proportional in (0.0, 0.1, 0.2, 0.4, 0.6, 0.8):
        for integral in (0.05, 0.1, 0.15, 0.2, 0.3, 0.4):
            mine = np.array([rms(ClosedLoop(print_, ProportionalIntegral(
                print_.targets, proportional, integral)).run().error) for print_ in prints])
            found.append((proportional, integral, float(np.mean((mine / none)**2))))
    return sorted(found, key=lambda entry: entry[2])
