"""How wide, even and unbroken strands are."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.amounts import LEAST_KNOWN, lengths
from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.printability.flat_print import FlatPrint, Outline
from bpc_perception.core.printability.metric import Metric
from bpc_perception.core.printability.uncertainty import (
    draw_side_errors,
    independent,
    sigma_of_mean,
)

PERCENT = 100
OF_WIDTH = ('width', 'filament_to_nozzle_ratio', 'width_accuracy', 'stability', 'uniformity')


def strand_metrics(flat: FlatPrint, chosen: Flags, of: str, nozzle: float,
                   wanted: Array | None) -> list[Metric]:
    """Return what chosen samples (N,) of strands tell.

    Args:
        flat: the print.
        chosen: (N,) samples.
        of: what they are, as 'stroke 3'.
        nozzle: inner diameter of the nozzle [m]; NaN = not known.
        wanted: (N,) width that was wanted [m]; None = not known.
    """
    step = lengths(flat.arc_length, flat.stroke)
    measured = chosen & (flat.outline == Outline.MEASURED)
    inked = chosen & (flat.outline != Outline.BARE)
    seen, length = float(step[measured].sum()), float(step[inked].sum())
    found = [continuity(flat, chosen, of)]
    if not seen > 0 or seen < LEAST_KNOWN * length:
        reason = f'{seen / length:.0%} of the ink are measured' if length > 0 else 'no ink is seen'
        return found + [Metric.unknown(name, of, reason) for name in OF_WIDTH]
    width = (flat.left + flat.right)[measured]
    mean, count = float(width.mean()), len(width)
    strokes = len(np.unique(flat.stroke[measured]))
    sigma = sigma_of_mean(flat.sigma[measured], seen, strokes)
    found.append(Metric('width', of, mean, sigma, count, '', float(width.std())))
    found.append(Metric('filament_to_nozzle_ratio', of, mean / nozzle, sigma / nozzle, count)
                 if nozzle > 0 else
                 Metric.unknown('filament_to_nozzle_ratio', of,
                                'the inner diameter of the nozzle is not given'))
    target = float(np.mean(wanted[measured])) if wanted is not None else np.nan
    found.append(Metric('width_accuracy', of, PERCENT * mean / target, PERCENT * sigma / target,
                        count) if target > 0 else
                 Metric.unknown('width_accuracy', of, 'no target is set'))
    variation = float(width.std()) / mean
    found.append(Metric('stability', of, 1 - variation,
                        variation / np.sqrt(2 * independent(seen)), count))
    return [*found, uniformity(flat, measured, of)]


def continuity(flat: FlatPrint, chosen: Flags, of: str) -> Metric:
    """Return which share of the commanded length has ink, of what is seen of it.

    What is not seen widens the uncertainty.
    """
    step = lengths(flat.arc_length, flat.stroke)
    inked = chosen & (flat.outline <= Outline.INTERPOLATED)
    bare = chosen & (flat.outline == Outline.BARE)
    nominal = float(step[chosen].sum())
    ink, known = float(step[inked].sum()), float(step[inked | bare].sum())
    if not nominal > 0 or known < LEAST_KNOWN * nominal:
        return Metric.unknown('continuity', of, 'less than half of the length is seen')
    ends = 2 + np.count_nonzero(np.diff(bare[chosen].astype(int)))
    # An end of ink lies anywhere between two samples; what is not seen has ink or has not.
    unsure = np.hypot(np.sqrt(ends) * flat.spacing, nominal - known) / np.sqrt(12)
    unseen = 1 - known / nominal
    return Metric('continuity', of, ink / known, float(unsure) / nominal,
                  int(np.count_nonzero(inked | bare)),
                  f'{unseen:.1%} of the length are not seen' if unseen > 1e-6 else '')


def uniformity(flat: FlatPrint, measured: Flags, of: str) -> Metric:
    """Return U of the strands of samples (N,) that are measured.

    The edges are taken along the straightened path, so that a bend of it does not count.
    """
    start = np.flatnonzero(measured[:-1] & measured[1:] & (flat.stroke[:-1] == flat.stroke[1:]))
    along = np.diff(flat.arc_length)[start]
    if not len(start):
        return Metric.unknown('uniformity', of, 'no two neighbours are measured')
    sides = np.stack((flat.left, flat.right))

    def factor(distance: Array) -> Array:
        edge = np.hypot(along, np.diff(distance, axis=-1)[..., start])
        return np.asarray(edge.sum(axis=(-1, -2)) / (2 * along.sum()))

    drawn = factor(sides + draw_side_errors(flat.sigma, flat.stroke, flat.spacing))
    return Metric('uniformity', of, float(factor(sides)), float(drawn.std()), len(start) + 1)
