"""Prints that go wrong, with and without advice: how near to the target the bead comes."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.closed_loop.situations import make_situation, SITUATIONS
from bpc_sim.studies.closed_loop.figure import draw
from bpc_sim.studies.closed_loop.outcome import evaluate, Outcome, settled_deviation
from bpc_sim.studies.closed_loop.trial import CONTROLLERS, run_print
from bpc_sim.studies.study_runner import Row, Study


def tasks(seeds: int) -> list[tuple[str, int]]:
    """Return scenario and seed of each task."""
    return [(name, seed) for name in SITUATIONS for seed in range(seeds)]


def work(task: tuple[str, int]) -> list[Outcome]:
    """Print once under each controller."""
    print_ = make_situation(*task)
    traces = {name: run_print(print_, name) for name in CONTROLLERS}
    side = np.sign(settled_deviation(traces['none'], print_).mean())
    return [evaluate(trace, print_, name, float(side)) for name, trace in traces.items()]


def rows(found: list[list[Outcome]]) -> list[Row]:
    """Return a row for each scenario and controller, with all seeds together."""
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
    """Return the means over the seeds, and the worst of what has a limit.

    Args:
        mine: outcomes of one scenario and controller.
        none: outcomes of the same prints without feedback.
    """
    def every(name: str, of: list[Outcome] = mine) -> Array:
        return np.array([getattr(one, name) for one in of])

    def worst(values: Array) -> float:
        # NaN in one of the seeds means that it never happened, which is worse than any number.
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
                    tasks, work, rows, seeds=20, processes=2, draw=draw)
