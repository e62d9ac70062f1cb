"""All numbers of printability of a print."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.printability.collapse import collapse_metrics
from bpc_perception.core.printability.flat_print import FlatPrint, lay_flat
from bpc_perception.core.printability.fusion import fusion_metrics
from bpc_perception.core.printability.metric import Metric
from bpc_perception.core.printability.pores import find_pores, Pore
from bpc_perception.core.printability.strands import strand_metrics
from bpc_perception.core.printability.turns import turn_fidelity
from bpc_perception.core.profile import Status, ThicknessProfile


@dataclass(frozen=True)
class Conditions:
    """What is known beside a profile.

    Attributes:
        nozzle: inner diameter of the nozzle [m]; NaN = not known.
        target: (N,) width that was wanted at each sample of the profile [m]; None = not known.
        cloud: (M, 3) points of the last capture in the base frame [m]; None = there is none.

    Raises:
        ValueError: a diameter or a target is not above 0.
    """

    nozzle: float = np.nan
    target: Array | None = None
    cloud: Array | None = None

    def __post_init__(self) -> None:
        if self.nozzle <= 0 or (self.target is not None and not (self.target > 0).all()):
            raise ValueError('printability: expected lengths above 0, found others')


@dataclass(frozen=True)
class Printability:
    """How well an ink was printed.

    Attributes:
        flat: the print as it was looked at.
        metrics: of the print, its strokes and its strands.
        pores: of it, row by row.
    """

    flat: FlatPrint
    metrics: list[Metric]
    pores: list[Pore]


def assess(profile: ThicknessProfile, conditions: Conditions) -> Printability:
    """Return all numbers of printability that a profile tells."""
    flat = lay_flat(profile)
    target = None if conditions.target is None else conditions.target[flat.index]
    # Where no target is set, strands are meant to be as wide as the nozzle.
    intended = target if target is not None else (
        np.full(len(flat.stroke), conditions.nozzle) if conditions.nozzle > 0 else None)
    pores = find_pores(flat, intended)
    everything = np.ones(len(flat.stroke), bool)
    metrics = [*pore_metrics(flat, pores, intended is not None),
               *strand_metrics(flat, everything, 'print', conditions.nozzle, target),
               turn_fidelity(flat)]
    numbers = np.unique(flat.stroke).tolist()
    for number in numbers if len(numbers) > 1 else ():
        metrics += strand_metrics(flat, flat.stroke == number, f'stroke {number}',
                                  conditions.nozzle, target)
    metrics += fusion_metrics(flat, profile.status[flat.index] == Status.JUNCTION,
                              np.nan if intended is None else float(np.median(intended)))
    spans = collapse_metrics(flat, profile.height[flat.index], conditions.cloud)
    metrics += spans
    if spans[0].of != 'print':
        metrics.append(_mean('collapse_factor', [(span.value, span.sigma) for span in spans],
                             'of no span it is told'))
    return Printability(flat, metrics, pores)


def pore_metrics(flat: FlatPrint, pores: list[Pore], with_width: bool) -> list[Metric]:
    """Return the means over the pores that are told, without those that joined.

    Args:
        flat: the print.
        pores: its pores.
        with_width: whether it is known how wide strands were meant to be.
    """
    if flat.curved:
        missing = 'the bed is not flat, and areas would be wrong'
    elif not np.isfinite(flat.width):
        missing = 'no width is measured'
    elif not pores:
        missing = 'the strands enclose none'
    else:
        missing = 'no pore has an outline that is seen all around'
    alone = [pore for pore in pores if pore.intended <= 1]
    values = {
        'pore_area': [(pore.area, pore.area_sigma) for pore in alone],
        'pore_printability': [(pore.printability, pore.printability_sigma) for pore in alone],
        'mesh_printability': [(pore.mesh_printability, pore.mesh_printability_sigma)
                              for pore in alone],
        'pore_size_accuracy': [(pore.size_accuracy, pore.size_accuracy_sigma)
                               for pore in alone]}
    no_width = 'neither a target nor the inner diameter of the nozzle is known'
    return [_mean(name, found, no_width if not with_width and name in (
        'mesh_printability', 'pore_size_accuracy') else missing, len(pores) - len(alone))
        for name, found in values.items()]


def _mean(name: str, values: list[tuple[float, float]], missing: str,
          joined: int = 0) -> Metric:
    """Return the mean of values with their uncertainties, which are taken to be alike.

    Args:
        name: of the metric.
        values: of it and its 1-sigma uncertainty, for each that there is.
        missing: why none is known.
        joined: how many more there are that are several in one.
    """
    known = np.array([each for each in values if np.isfinite(each[0])]).reshape(-1, 2)
    if not len(known):
        return Metric.unknown(name, 'print', missing)
    left_out = len(values) - len(known)
    notes = [f'{left_out} more are not told'] * (left_out > 0)
    notes += [f'{joined} more joined with others'] * (joined > 0)
    sigmas = known[np.isfinite(known[:, 1]), 1]
    return Metric(name, 'print', float(known[:, 0].mean()),
                  float(sigmas.mean()) if len(sigmas) else np.nan, len(known), '; '.join(notes),
                  float(known[:, 0].std(ddof=1)) if len(known) > 1 else np.nan)
