"""How far a strand sags that spans from one strand below it to the next.

The area under it is not seen from above. But its top is, and sags as its underside does: where it
rests on a support it lies the support's height above what it spans.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid
from scipy.spatial import cKDTree
import shapely

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.printability.bead_union import bead_union
from bpc_perception.core.printability.flat_print import FlatPrint
from bpc_perception.core.printability.metric import Metric

PERCENT = 100
NAME = 'collapse_factor'
ON_TOP = 0.15  # widths from the path, within which the cloud tells the top of a strand
LEAST_SEEN = 0.8  # share of a span whose top is seen
LEAST_SAMPLES = 3  # in a span
MAD_TO_SIGMA = 1.4826


@dataclass(frozen=True)
class Span:
    """A strand between two supports.

    Attributes:
        stroke: its number.
        free: (K,) its samples between the edges of the supports.
        rests: samples above the middle of the first and of the second support.
    """

    stroke: int
    free: Index
    rests: tuple[Index, Index]


def collapse_factor(sag: Array, along: Array, support: float) -> float:
    """Return Cf = (A_t - A_a) / A_t x 100 of a span [%].

    Args:
        sag: (K,) how far the strand hangs below the line from support to support [m].
        along: (K,) places of these, increasing [m].
        support: height of the supports [m].
    """
    return float(PERCENT * trapezoid(sag, along) / (support * (along[-1] - along[0])))


def tops(flat: FlatPrint, cloud: Array) -> Array:
    """Return how high (N,) the ink on the path lies above the plane [m]; NaN where not seen.

    Args:
        flat: the print.
        cloud: (M, 3) points of the last capture in the base frame, without NaN [m].
    """
    place = cloud - flat.origin
    near = cKDTree(place @ flat.axes.T).query_ball_point(flat.points, ON_TOP * flat.width)
    height = place @ np.cross(flat.axes[0], flat.axes[1])
    return np.array([np.median(height[found]) if found else np.nan for found in near])


def collapse_metrics(flat: FlatPrint, height: Array, cloud: Array | None) -> list[Metric]:
    """Return the collapse factor of each span of the uppermost layer, which nothing covers.

    Args:
        flat: the print.
        height: (N,) of the ink above what lay there before [m]; NaN = not known.
        cloud: (M, 3) points of the last capture in the base frame [m]; None = there is none.
    """
    uppermost = flat.layer == flat.layer.max(initial=0)
    if uppermost.all() or not np.isfinite(flat.width):
        return [Metric.unknown(NAME, 'print', 'no strand lies on others')]
    if cloud is None or not len(cloud):
        return [Metric.unknown(NAME, 'print', 'how far a strand sags is not in a result: name '
                               'the recording in its place')]
    spans = find_spans(flat, uppermost)
    if not spans:
        return [Metric.unknown(NAME, 'print', 'no strand spans from one below to the next')]
    top = tops(flat, cloud)
    below = height[flat.layer == flat.layer.max() - 1]
    support = below[np.isfinite(below) & (below > 0)]
    return [_collapse(flat, span, top, support) for span in spans]


def find_spans(flat: FlatPrint, upper: Flags) -> list[Span]:
    """Return where strands of a layer (N,) hang between those of the layer below."""
    below = bead_union(flat, flat.known & (flat.layer == flat.layer[upper][0] - 1))
    found = []
    for number in np.unique(flat.stroke[upper]).tolist():
        own = np.flatnonzero(flat.stroke == number)
        on = shapely.contains_xy(below, flat.points[own])
        parts = np.split(own, np.flatnonzero(np.diff(on)) + 1)
        # Every second part rests. What is before the first of these or behind the last juts out.
        for place in range(1 if on[0] else 2, len(parts) - 1, 2):
            if len(parts[place]) >= LEAST_SAMPLES:
                found.append(Span(number, parts[place], (
                    _middle(parts[place - 1]), _middle(parts[place + 1]))))
    return found


def _middle(samples: Index) -> Index:
    """Return the middle third of samples (K,), where a round support is highest."""
    third = (len(samples) - 1) // 3
    return samples[third:len(samples) - third]


def _collapse(flat: FlatPrint, span: Span, top: Array, support: Array) -> Metric:
    """Return the collapse factor of a span.

    Args:
        flat: the print.
        span: where it is.
        top: (N,) height of the ink on the path [m].
        support: heights of the strands below that are known [m].
    """
    first = span.free[0]
    of = (f'stroke {span.stroke}, {1e3 * flat.arc_length[first]:.1f} to '
          f'{1e3 * flat.arc_length[span.free[-1]]:.1f} mm')
    if not flat.known[span.free].all():
        return Metric.unknown(NAME, of, 'it has gaps, or is not measured everywhere')
    seen = span.free[np.isfinite(top[span.free])]
    held = [rest[np.isfinite(top[rest])] for rest in span.rests]
    if len(seen) < LEAST_SEEN * len(span.free) or not all(len(rest) for rest in held):
        return Metric.unknown(NAME, of, 'the last capture does not show its top', len(seen))
    if not len(support):
        return Metric.unknown(NAME, of, 'the height of the strands below is not known', len(seen))
    along = flat.arc_length[seen]
    line = np.interp(along, [np.mean(flat.arc_length[rest]) for rest in held],
                     [np.median(top[rest]) for rest in held])
    high = float(np.median(support))
    factor = collapse_factor(line - top[seen], along, high)
    noise = MAD_TO_SIGMA * float(np.median(np.abs(np.diff(top[seen])))) / np.sqrt(2)
    count = min(len(rest) for rest in held)
    return Metric(NAME, of, factor,
                  float(np.hypot(PERCENT * noise * np.sqrt(1 / (2 * count) + 1 / len(seen)) / high,
                                 factor * np.std(support) / high)), len(seen))
