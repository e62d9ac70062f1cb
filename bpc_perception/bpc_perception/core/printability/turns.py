"""The turns of a print: where they are, and how wide the strand is at their apex."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.printability.flat_print import FlatPrint, Outline
from bpc_perception.core.printability.metric import Metric

REACH = 1.5  # widths on either side, between which the direction is compared
LEAST_TURN = np.radians(45)
LONGEST_TURN = 10.0  # widths; what bends for longer is a curve
NARROWEST, WIDEST = 0.7, 1.5  # of the median width, at the apex of a good turn


def find_turns(flat: FlatPrint) -> Index:
    """Return the sample (T,) at the apex of each turn, the middle of where the path bends."""
    found = []
    for number in np.unique(flat.stroke) if np.isfinite(flat.width) else ():
        own = np.flatnonzero(flat.stroke == number)
        bends = _turning(flat, own) >= LEAST_TURN
        for part in np.split(own, np.flatnonzero(np.diff(bends)) + 1):
            length = flat.arc_length[part[-1]] - flat.arc_length[part[0]]
            if bends[part[0] - own[0]] and length <= LONGEST_TURN * flat.width:
                found.append(part[len(part) // 2])
    return np.array(found, np.intp)


def _turning(flat: FlatPrint, own: Index) -> Array:
    """Return by which angle (K,) a stroke turns at each of its samples (K,) [rad]."""
    arc, points, reach = flat.arc_length[own], flat.points[own], REACH * flat.width
    before, after = (np.stack([np.interp(arc + way, arc, axis) for axis in points.T], axis=1)
                     for way in (-reach, reach))
    one, two = points - before, after - points
    angle = np.abs(np.arctan2(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0],
                              (one * two).sum(axis=1)))
    inner = (arc - arc[0] >= reach) & (arc[-1] - arc >= reach)
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
