"""Path points, one spacing apart along the poses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
import math

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import PathConfig

SCANNED_POSES = 256  # at once


@dataclass(frozen=True)
class PathPoint:
    """A point of a path.

    Attributes:
        time: when the nozzle passed [s].
        arc_length: from the start of the path [m].
        position: (3,) of the nozzle tip [m].
    """

    time: float
    arc_length: float
    position: Array


class PathResampler:
    """Places path points along the polyline of the poses, each ``spacing`` from the one before.

    A robot that trembles on the spot adds no length. No points are placed between poses that are
    more than ``maximum_gap`` apart in time, or in a leap; the straight line between them still
    counts as length.
    """

    def __init__(self, config: PathConfig, last: PathPoint | None) -> None:
        """Go on after the last point of a path; None = begin with the first pose."""
        self._spacing = config.spacing
        self._maximum_gap = config.maximum_gap
        self._last = last
        self._poses = np.empty((0, 6))  # from the last path point on, see PoseSmoother.take
        self._scanned = 0  # poses known to be nearer than one spacing to the last path point

    @property
    def complete_until(self) -> float:
        """Time up to which all points are placed [s]; -inf before the first pose."""
        return float(self._poses[-1, 0]) if len(self._poses) else -math.inf

    def add(self, poses: Array) -> list[PathPoint]:
        """Add averaged poses (N, 6), see PoseSmoother.take; return the points up to them."""
        self._poses = np.concatenate((self._poses, poses))
        points = list(self._place())
        keep = max(self._scanned - 1, 0)
        self._poses, self._scanned = self._poses[keep:], self._scanned - keep
        return points

    def _place(self) -> Iterator[PathPoint]:
        if self._last is None and len(self._poses):
            first = self._poses[0]
            self._last = PathPoint(first[0], 0.0, first[1:4])
            yield self._last
        while self._last is not None and self._scan_for_next(self._last):
            self._last = self._next_point(self._last, self._scanned)
            yield self._last

    def _scan_for_next(self, last: PathPoint) -> bool:
        """Go on to the first pose one spacing or more away; return whether there is one."""
        while self._scanned < len(self._poses):
            block = self._poses[self._scanned:self._scanned + SCANNED_POSES]
            offset = block[:, 1:4] - last.position
            away = np.flatnonzero(
                (offset * offset).sum(axis=1) >= self._spacing * self._spacing)
            if len(away):
                self._scanned += int(away[0])
                return True
            self._scanned += len(block)
        return False

    def _next_point(self, last: PathPoint, index: int) -> PathPoint:
        """Return the path point between the poses before and at ``index``."""
        end = self._poses[index]
        # Before the first pose after a path left off nothing is known.
        if index == 0 or end[4] - self._poses[index - 1, 4] > self._maximum_gap or end[5]:
            arc_length = last.arc_length + math.dist(last.position, end[1:4])
            return PathPoint(end[0], arc_length, end[1:4])
        return self._between(last, self._poses[index - 1], end)

    def _between(self, last: PathPoint, start: Array, end: Array) -> PathPoint:
        """Return the point between two poses (5,) that is one spacing from the last point."""
        step = end[1:4] - start[1:4]
        # |start + share * step - last| = spacing, a quadratic in share.
        back = start[1:4] - last.position
        a, b = float((step * step).sum()), float((step * back).sum())
        c = float((back * back).sum()) - self._spacing ** 2
        share = min(max((-b + math.sqrt(max(b * b - a * c, 0.0))) / a, 0.0), 1.0)
        time = start[0] + share * (end[0] - start[0])
        return PathPoint(time, last.arc_length + self._spacing, start[1:4] + share * step)
