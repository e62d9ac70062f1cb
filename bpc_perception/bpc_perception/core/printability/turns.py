"""The turns of a print: where they are, and how wide the strand is at their apex."""

from __future__ import annotations

import numpy as np
from scipy.signal import find_peaks

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.printability.flat_print import FlatPrint, Outline
from bpc_perception.core.printability.metric import Metric

LEAST_TURN = np.radians(45)  # within a width on either side
NARROWEST, WIDEST = 0.7, 1.5  # of the median width, at the apex of a good turn


def find_turns(flat: FlatPrint) -> Index:
    """Return the sample (T,) at the apex of each turn."""
    found = []
    for number in np.unique(flat.stroke):
        own = np.flatnonzero(flat.stroke == number)
        if len(own) > 2 and np.isfinite(flat.width):
            # A flat top is one turn; zeros beside it let a turn near an end stand out.
            angle = np.concatenate(([0.0], _turning(flat, own), [0.0]))
            tops, _ = find_peaks(angle, height=LEAST_TURN,
                                 distance=max(1, round(2 * flat.width / flat.spacing)))
            found.append(own[tops - 1])
    return np.concatenate(found) if found else np.empty(0, np.intp)


def _turning(flat: FlatPrint, own: Index) -> Array:
    """Return by which angle (K,) a stroke turns at each of its samples (K,) [rad]."""
    arc, points = flat.arc_length[own], flat.points[own]
    before, after = (np.stack([np.interp(arc + reach, arc, axis) for axis in points.T], axis=1)
                     for reach in (-flat.width, flat.width))
    one, two = points - before, after - points
    angle = np.abs(np.arctan2(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0],
                              (one * two).sum(axis=1)))
    inner = (arc - arc[0] >= flat.width) & (arc[-1] - arc >= flat.width)
    return np.where(inner, angle, 0.0)


def legs(flat: FlatPrint) -> Index:
    """Return the number (N,) of the strand between two turns that each sample belongs to."""
    begins = np.diff(flat.stroke, prepend=flat.stroke[:1] - 1) != 0
    begins[find_turns(flat)] = True
    return np.asarray(np.cumsum(begins))


def turn_fidelity(flat: FlatPrint) -> Metric:
    """Return the share of turns that are as wide at the apex as they should be."""
    apexes, of = find_turns(flat), 'print'
    if not len(apexes):
        return Metric.unknown('turn_fidelity', of, 'the path has no turns')
    seen = apexes[flat.outline[apexes] == Outline.MEASURED]
    if not len(seen):
        return Metric.unknown('turn_fidelity', of,
                              f'at none of the {len(apexes)} turns is the width measured')
    relative = (flat.left + flat.right)[seen] / flat.width
    share = float(np.mean((relative >= NARROWEST) & (relative <= WIDEST)))
    note = f'{len(apexes) - len(seen)} more turns are not measured' * (len(seen) < len(apexes))
    # As of a share of so many, whose true value is never surely 0 or 1.
    fair = (share * len(seen) + 1) / (len(seen) + 2)
    return Metric('turn_fidelity', of, share,
                  float(np.sqrt(fair * (1 - fair) / (len(seen) + 3))), len(seen), note)
