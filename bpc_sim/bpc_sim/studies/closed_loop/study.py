"""Prints that go wrong, with and without advice: how near to the target the bead comes.

Layers of one path are printed one after the other, by controllers that learn and without any.
"""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.closed_loop.situations import make_situation, SITUATIONS
from bpc_sim.studies.closed_loop.figure import draw
from bpc_sim.studies.closed_loop.outcome import evaluate, Outcome, settled_deviation
from bpc_sim.studies.closed_loop.trial import (
    CONTROLLERS,
    LAYERS,
    LEARNING,
    print_layers,
    run_print,
)
from bpc_sim.studies.study_runner import Row, Study


def tasks(seeds: int) -> list[tuple[str, int, tuple[str, ...]]]:
    """Return scenario, seed and the controllers that print layers, of each task."""
    return [(name, seed, LEARNING) for name in SITUATIONS for seed in range(seeds)]


def work(task: tuple[str, int, tuple[str, ...]]) -> list[Outcome]:
    """Print once under each controller, and layers under those that learn."""
    name, seed, learning = task
    print_ = make_situation(name, seed)
    learning = learning if np.isinf(print_.fault) else ()
    layers = range(1, LAYERS + 1 if learning else 2)
    none = [run_print(print_.in_layer(layer), 'none') for layer in layers]
    side = float(np.sign(settled_deviation(none[0], print_).mean()))
    found = [evaluate(run_print(print_, name), print_, name, side)
             for name in CONTROLLERS if name != 'none']
    layered = {'none': none, **{name: print_layers(print_, name) for name in learning}}
    for name, traces in layered.items():
        found += [evaluate(trace, print_, name, side, layer)
                  for layer, trace in enumerate(traces, 1)]
    return found


def rows(found: list[list[Outcome]]) -> list[Row]:
    """Return a row for each scenario, controller and layer, with all seeds together."""
    groups: dict[tuple[str, str, int], list[Outcome]] = {}
    for one in (one for several in found for one in several):
        groups.setdefault((one.scenario, one.controller, one.layer), []).append(one)
    order = ('none', *(name for name in CONTROLLERS if name != 'none'), *LEARNING)
    keys = sorted(groups, key=lambda key: (list(SITUATIONS).index(key[0]), order.index(key[1]),
                                           key[2]))
    return [row(groups[key], groups[key[0], 'none', key[2]]) for key in keys]


def row(mine: list[Outcome], none: list[Outcome]) -> Row:
    """Return the means over the seeds, and the worst of what has a limit.

    Args:
        mine: outcomes of one scenario, controller and layer.
        none: outcomes of the same layers without feedback.
    """
    def every(name: str, of: list[Outcome] = mine) -> Array:
        return np.array([getattr(one, name) for one in of])

    def worst(values: Array) -> float:
        # NaN in one of the seeds means that it never happened, which is worse than any number.
        return float(values.max()) if len(values) else np.nan

    whole = every('rms') / every('rms', none)
    ratio = every('rms_settled') / every('rms_settled', none)
    return {
        'scenario': mine[0].scenario, 'controller': mine[0].controller,
        'layer': mine[0].layer, 'prints': len(mine),
        'rms_percent': float(every('rms').mean()) * 100,
        'rms_ratio': float(whole.mean()), 'rms_ratio_max': worst(whole),
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
                    'capture, a PI controller on the mean width, and the advice, on flow or '
                    'speed; layer after layer with a P-type learning law, and with schedule and '
                    'advice',
                    tasks, work, rows, seeds=20, processes=2, draw=draw)
