"""Where parallel strands run into each other."""

from __future__ import annotations

from dataclasses import dataclass

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


def fusion_metrics(flat: FlatPrint, junction: Flags) -> list[Metric]:
    """Return distance, fused length and fusion of each pair of neighbouring strands.

    Args:
        flat: the print.
        junction: (N,) where the status is JUNCTION.
    """
    if not np.isfinite(flat.width):
        return [Metric.unknown(name, 'print', 'no width is measured') for name in NAMES]
    found = [metric for pair in _neighbours(flat) for metric in _fusion(flat, pair, junction)]
    return found or [Metric.unknown(name, 'print', 'no strands run beside each other within '
                                    f'{FARTHEST:g} widths') for name in NAMES]


def _neighbours(flat: FlatPrint) -> list[Neighbours]:
    """Return all pairs of strands of one layer that run beside each other."""
    number = legs(flat)
    samples = {leg: np.flatnonzero(number == leg) for leg in np.unique(number).tolist()}
    trees = {leg: cKDTree(flat.points[own]) for leg, own in samples.items()}
    reach = FARTHEST * flat.width
    found = []
    for one, own in samples.items():
        for two in samples:
            if two <= one or flat.layer[own[0]] != flat.layer[samples[two][0]]:
                continue
            distance, place = trees[two].query(flat.points[own], distance_upper_bound=reach)
            near = np.isfinite(distance)
            other = samples[two][np.minimum(place, len(samples[two]) - 1)]
            way = flat.points[other] - flat.points[own]
            beside = (near & (np.abs((flat.ahead[own] * flat.ahead[other]).sum(axis=1))
                              > PARALLEL)
                      # Not behind the end of the other.
                      & (np.abs((way * flat.ahead[other]).sum(axis=1)) <= flat.spacing))
            if np.count_nonzero(beside) >= LEAST_BESIDE:
                found.append(Neighbours((one, two), own[beside], other[beside],
                                        distance[beside]))
    return found


def _fusion(flat: FlatPrint, pair: Neighbours, junction: Flags) -> list[Metric]:
    """Return the metrics of a pair."""
    of = f'strands {pair.legs[0]} and {pair.legs[1]}'
    step = lengths(flat.arc_length, flat.stroke)[pair.own]
    told = (flat.outline == Outline.MEASURED)[pair.own] & (
        flat.outline == Outline.MEASURED)[pair.other]
    fused = told & (pair.distance <= _facing(flat, pair.own, pair.other)
                    + _facing(flat, pair.other, pair.own))
    joined = (junction[pair.own] | junction[pair.other]) & (
        pair.distance <= TOUCHING * flat.width)
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
    own = len(measured) > 0
    width = float(np.mean((flat.left + flat.right)[measured])) if own else flat.width
    note = f'{1e3 * unseen:.1f} mm are not seen' * (unseen > 0)
    return [distance, Metric('fused_length', of, length, sigma, len(step), note),
            Metric('fusion', of, length / width, sigma / width, len(step),
                   note if own else 'f_t is the median width of the print')]


def _facing(flat: FlatPrint, own: Index, other: Index) -> Array:
    """Return how far samples (K,) reach to the side on which others (K,) lie [m]."""
    way, ahead = flat.points[other] - flat.points[own], flat.ahead[own]
    on_left = ahead[:, 0] * way[:, 1] - ahead[:, 1] * way[:, 0] > 0
    return np.where(on_left, flat.left[own], flat.right[own])
