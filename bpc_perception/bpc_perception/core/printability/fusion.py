"""Where parallel strands run into each other."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.amounts import lengths
from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.printability.flat_print import FlatPrint, Outline
from bpc_perception.core.printability.metric import Metric
from bpc_perception.core.printability.turns import legs

FARTHEST = 3.0  # widths between the lines of two strands that may be said to be neighbours
TOUCHING = 1.5  # widths, within which a JUNCTION beside a parallel strand is that with it
PARALLEL = np.cos(np.radians(20))
LEAST_BESIDE = 3  # samples
NAMES = ('strand_distance', 'fused_length', 'fusion')


@dataclass(frozen=True)
class Neighbours:
    """Two parallel strands, at the K samples of the one that have the other beside them.

    Attributes:
        legs: numbers of both.
        own, other: (K,) samples of the one, and the nearest of the other.
        distance: (K,) between the lines of the path [m].
    """

    legs: tuple[int, int]
    own: Index
    other: Index
    distance: Array


def fusion_metrics(flat: FlatPrint, junction: Flags, wanted: float) -> list[Metric]:
    """Return distance, fused length and fusion of each pair of neighbouring strands.

    Args:
        flat: the print.
        junction: (N,) where the status is JUNCTION.
        wanted: width of a strand that was wanted [m]; NaN = not known.
    """
    # Where all strands touch, none has a width.
    width = flat.width if np.isfinite(flat.width) else wanted
    if not np.isfinite(width):
        return [Metric.unknown(name, 'print', 'no width is measured') for name in NAMES]
    found = [metric for pair in _neighbours(flat, width)
             for metric in _fusion(flat, pair, junction, width)]
    return found or [Metric.unknown(name, 'print', 'no strands run beside each other within '
                                    f'{FARTHEST:g} widths') for name in NAMES]


def _neighbours(flat: FlatPrint, width: float) -> list[Neighbours]:
    """Return all pairs of strands of one layer that run beside each other, none between them."""
    number = legs(flat)
    found = []
    for layer in np.unique(flat.layer):
        of_layer = np.flatnonzero(flat.layer == layer)
        every = cKDTree(flat.points[of_layer])
        for pair in combinations(np.unique(number[of_layer]).tolist(), 2):
            one, two = (np.flatnonzero(number == leg) for leg in pair)
            own, other, distance = _beside(flat, one, two, FARTHEST * width)
            _, middle = every.query((flat.points[own] + flat.points[other]) / 2)
            alone = np.isin(number[of_layer[middle]], pair)
            if np.count_nonzero(alone) >= LEAST_BESIDE:
                found.append(Neighbours(pair, own[alone], other[alone], distance[alone]))
    return found


def _beside(flat: FlatPrint, one: Index, two: Index, reach: float) -> tuple[Index, Index, Array]:
    """Return where two strands run beside each other.

    Args:
        flat: the print.
        one: samples of the one.
        two: samples of the other.
        reach: how far they may be apart [m].

    Returns:
        (K,) samples of the one, (K,) the nearest of the other, (K,) distances [m].
    """
    distance, place = cKDTree(flat.points[two]).query(flat.points[one])
    other = two[place]
    way, ahead = flat.points[other] - flat.points[one], flat.ahead[other]
    parallel = np.abs((flat.ahead[one] * ahead).sum(axis=1)) > PARALLEL
    behind_end = np.abs((way * ahead).sum(axis=1)) > flat.spacing
    within_turn = np.abs(flat.arc_length[other] - flat.arc_length[one]) <= np.pi / 2 * distance
    beside = (distance <= reach) & parallel & ~behind_end & ~within_turn
    return one[beside], other[beside], distance[beside]


def _fusion(flat: FlatPrint, pair: Neighbours, junction: Flags, typical: float) -> list[Metric]:
    """Return the metrics of a pair of strands of typical width [m]."""
    of = f'strands {pair.legs[0]} and {pair.legs[1]}'
    step = lengths(flat.arc_length, flat.stroke)[pair.own]
    told = (flat.outline == Outline.MEASURED)[pair.own] & (
        flat.outline == Outline.MEASURED)[pair.other]
    fused = told & (pair.distance <= _facing(flat, pair.own, pair.other)
                    + _facing(flat, pair.other, pair.own))
    joined = (junction[pair.own] | junction[pair.other]) & (
        pair.distance <= TOUCHING * typical)
    bare = (flat.outline[pair.own] == Outline.BARE) | (flat.outline[pair.other] == Outline.BARE)
    unseen = float(step[~(told | joined | bare)].sum())
    distance = Metric('strand_distance', of, float(np.median(pair.distance)),
                      float(pair.distance.std()), len(step))
    if unseen > float(step.sum()) / 2:
        reason = 'less than half of what lies beside each other is seen'
        return [distance, *(Metric.unknown(name, of, reason) for name in NAMES[1:])]
    length = float(step[fused | joined].sum())
    sigma = float(np.hypot(2 * flat.spacing, unseen) / np.sqrt(12))
    both = np.concatenate((pair.own, pair.other))
    measured = both[flat.outline[both] == Outline.MEASURED]
    note = f'{1e3 * unseen:.1f} mm are not seen' * (unseen > 0)
    fused_length = Metric('fused_length', of, length, sigma, len(step), note)
    if not len(measured):
        return [distance, fused_length, Metric.unknown(
            'fusion', of, 'they touch all along, so that f_t is not measured')]
    width = float(np.mean((flat.left + flat.right)[measured]))
    return [distance, fused_length,
            Metric('fusion', of, length / width, sigma / width, len(step), note)]


def _facing(flat: FlatPrint, own: Index, other: Index) -> Array:
    """Return how far samples (K,) reach to the side on which others (K,) lie [m]."""
    way, ahead = flat.points[other] - flat.points[own], flat.ahead[own]
    on_left = ahead[:, 0] * way[:, 1] - ahead[:, 1] * way[:, 0] > 0
    return np.where(on_left, flat.left[own], flat.right[own])
