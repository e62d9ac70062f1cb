"""Strokes and travel: where a path lays ink, and where it only goes from one stroke to the next.

A stroke is an uninterrupted run of path in which ink is commanded. The extruder says where; where
its state is unknown, the motion does: travel is lifted, or fast.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.geometry import unit_vectors
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.lifts import lifted_or_fast

SHORTEST_M = 0.0005  # of a stroke, and of travel between strokes
# The extruder is asked some ten times a second or more often. So much earlier or later than it
# says, a stroke may begin or end:
STATE_PERIOD_S = 0.1
REFERENCE_S = 0.3  # of the stroke before that, which tells how fast the nozzle went
FASTER = 1.5  # than that is travel,
HIGHER_M = 0.00015  # and so is what is higher
CORNER_POINTS = 5  # to either side, between which a path turns a corner
CORNER_RAD = 0.8
# Where no pose is known for longer, and the nozzle has moved on, nobody knows what it did.
OUTAGE_S, MOVED_M = 1.0, 0.002


def stroke_numbers(path: DepositionPath, height: Array, low: Flags) -> Index:
    """Return the number (N,) of the stroke to which each point of a path belongs; 0 = travel.

    Strokes are numbered from 1 in the order in which they were laid. One ends where the path was
    not heard for a while.

    Args:
        path: N points.
        height: (N,) of the nozzle tip above the bed [m].
        low: (N,) whether the nozzle went along the bed, near enough to lay ink on it.
    """
    if len(path) == 0:
        return np.zeros(0, np.intp)
    # An extruder that never says that it pushes is not heard.
    known = path.extruder_known & path.extruding.any()
    laying = path.extruding & known & ~overrun(path, path.extruding & known, height)
    if not known.all():
        laying |= ~known & ~lifted_or_fast(path, height)
    laying &= low
    unbroken = ~outages(path)
    laying = _without_short(laying, path.arc_length, unbroken)
    begins = laying & ~np.concatenate(([False], laying[:-1] & unbroken))
    return np.where(laying, np.cumsum(begins), 0)


def outages(path: DepositionPath) -> Flags:
    """Return whether (N - 1,) the way between neighbours of a path of N points is not known."""
    moved = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
    return np.asarray((np.diff(path.time) > OUTAGE_S) & (moved > MOVED_M))


def overrun(path: DepositionPath, laying: Flags, height: Array) -> Flags:
    """Return where (N,) the nozzle travels already, or still, though the extruder's state is on.

    The state is known only every now and then: the last one holds until the next. So near the
    ends of strokes, travel begins where the nozzle goes faster, is lifted, or turns a corner.

    Args:
        path: N points.
        laying: (N,) whether ink is pushed out, as far as is known.
        height: (N,) of the nozzle tip above the bed [m].
    """
    before, after = np.append(False, laying[:-1]), np.append(laying[1:], False)
    begins, ends = np.flatnonzero(laying & ~before), np.flatnonzero(laying & ~after)
    found = np.zeros(len(path), bool)
    if not len(begins) or len(path) < 2:
        return found
    runs = _Runs(begins, ends, np.maximum(np.cumsum(laying & ~before) - 1, 0))
    corner = corners(path.points)
    for at_end in (True, False):
        found |= laying & _beyond_end(path, runs, height, corner, at_end)
    return found


@dataclass(frozen=True)
class _Runs:
    """S runs of path on which ink is pushed out.

    Attributes:
        begins, ends: (S,) index of the first and of the last point of each.
        of: (N,) number of the run of each path point, or of the one before.
    """

    begins: Index
    ends: Index
    of: Index


def _beyond_end(path: DepositionPath, runs: _Runs, height: Array, corner: Array,
                at_end: bool) -> Flags:
    """Return which points (N,) are travel at the ends of runs, or at their begins."""
    time, arc, index = path.time, path.arc_length, np.arange(len(path))
    border, way = (runs.ends, -1) if at_end else (runs.begins, 1)
    inner, outer = (np.clip(np.searchsorted(time, time[border] + way * away),
                            runs.begins, runs.ends)
                    for away in (STATE_PERIOD_S, STATE_PERIOD_S + REFERENCE_S))
    length, duration = np.abs(arc[inner] - arc[outer]), np.abs(time[inner] - time[outer])
    speed = np.divide(length, duration, out=np.full(len(border), np.inf), where=duration > 0)
    zone = np.abs(time - time[border][runs.of]) < STATE_PERIOD_S
    # Of the step that leads away from the inner part of the run.
    step = np.diff(arc) / np.diff(time)
    own = np.concatenate((step[:1], step) if at_end else (step, step[-1:]))
    travel = zone & ((own > FASTER * speed[runs.of])
                     | (height > height[inner][runs.of] + HIGHER_M))
    sharp = np.where(zone, corner, 0.0)
    sharpest = np.maximum.reduceat(sharp, runs.begins)[runs.of]
    turned = (sharp == sharpest) & (sharp > 0)
    if at_end:
        first = np.where(travel, index, np.where(turned, index + 1, len(path)))
        return zone & (index >= np.minimum.reduceat(first, runs.begins)[runs.of])
    last = np.where(travel, index, np.where(turned, index - 1, -1))
    return zone & (index <= np.maximum.reduceat(last, runs.begins)[runs.of])


def corners(points: Array) -> Array:
    """Return by how much (N,) a path turns [rad] where it turns a corner; else 0."""
    turn = np.zeros(len(points))
    if len(points) > 2 * CORNER_POINTS:
        legs = unit_vectors(points[CORNER_POINTS:] - points[:-CORNER_POINTS])
        cos = np.einsum('nk,nk->n', legs[:-CORNER_POINTS], legs[CORNER_POINTS:])
        turn[CORNER_POINTS:-CORNER_POINTS] = np.arccos(np.clip(np.nan_to_num(cos, nan=1.0), -1, 1))
    return np.where(turn > CORNER_RAD, turn, 0.0)


def _without_short(laying: Flags, arc: Array, unbroken: Flags) -> Flags:
    """Return flags (N,) without runs of either kind that are too short: first of False.

    A run also ends where the path is not unbroken (N - 1,).
    """
    for kind in (False, True):
        same = np.concatenate(([True], (laying[1:] == laying[:-1]) & unbroken))
        begins = np.flatnonzero(~same)
        if not len(begins):
            break
        borders = np.concatenate(([0], begins, [len(laying)]))
        length = arc[borders[1:] - 1] - arc[borders[:-1]]
        short = (laying[borders[:-1]] == kind) & (length < SHORTEST_M)
        if not kind:
            short[[0, -1]] = False  # before the first stroke and after the last
        laying = laying ^ np.repeat(short, np.diff(borders))
    return laying
