"""A path that grows at its end, at a cost that does not depend on its length."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.path.deposition_path import DepositionPath


class GrowingPath:
    """The points of one print, numbered from its first.

    With more than ``MAXIMUM_POINTS`` (200 m of the default spacing) the older half is forgotten,
    so that no print fills the memory. Paths given out stay as they are.

    Attributes:
        print_id: identifier of the print.
        start_ns: when it started [ns].
        complete_until, finished: see DepositionPath.
    """

    MAXIMUM_POINTS = 1_000_000
    LEAST_ROOM_POINTS = 1024

    def __init__(self, print_id: str, start_ns: int, oldest: int = 0) -> None:
        """Begin without points; the first one to come has the number ``oldest``."""
        self.print_id = print_id
        self.start_ns = start_ns
        self.complete_until = -np.inf
        self.finished = False
        self._forgotten = oldest
        self._count = 0  # of those kept
        # In the order of ``append``, with room at the end.
        self._arrays: tuple[NDArray[Any], ...] = (
            np.empty(0), np.empty(0), np.empty((0, 3)), np.empty(0), np.empty(0),
            np.empty(0, bool), np.empty(0, bool))

    def __len__(self) -> int:
        return self._forgotten + self._count

    @property
    def oldest(self) -> int:
        """Number of the first point that is not forgotten."""
        return self._forgotten

    def last(self) -> Array:
        """Return time [s], arc length [m] and position x, y, z [m] of the last point (5,)."""
        time, arc, points = (array[self._count - 1] for array in self._arrays[:3])
        return np.array((time, arc, *points))

    def append(self, time: Array, arc_length: Array, points: Array, plunger_velocity: Array,
               flow_rate: Array, extruding: Flags, extruder_known: Flags) -> None:
        """Append points (N, 3) with what is known of each (N,); see DepositionPath."""
        new = (time, arc_length, points, plunger_velocity, flow_rate, extruding,
               extruder_known)
        self._make_room(len(time))
        end = self._count + len(time)
        for array, values in zip(self._arrays, new, strict=True):
            array[self._count:end] = values
        self._count = end

    def extend(self, first: int, path: DepositionPath) -> bool:
        """Append what is new of a part of this print that begins with point ``first``.

        Return False, and append nothing, if it is of another print or points before it are
        missing.
        """
        known = len(self) - first
        if path.print_id != self.print_id or path.start_ns != self.start_ns or known < 0:
            return False
        if path.complete_until >= self.complete_until:
            self.append(path.time[known:], path.arc_length[known:], path.points[known:],
                        path.plunger_velocity[known:], path.flow_rate[known:],
                        path.extruding[known:], path.extruder_known[known:])
            self.complete_until, self.finished = path.complete_until, path.finished
        return True

    def path(self, first: int = 0) -> DepositionPath:
        """Return the path from point ``first`` on, as far as it is kept; views, not copies."""
        kept = slice(max(first - self._forgotten, 0), self._count)
        time, arc, points, velocity, flow, extruding, extruder_known = (
            array[kept] for array in self._arrays)
        return DepositionPath(
            print_id=self.print_id, start_ns=self.start_ns, complete_until=self.complete_until,
            finished=self.finished, time=time, arc_length=arc, points=points,
            plunger_velocity=velocity, flow_rate=flow, extruding=extruding,
            extruder_known=extruder_known)

    def _make_room(self, more: int) -> None:
        """Make room for more points, and forget the older half if there are too many."""
        if self._count + more <= len(self._arrays[0]):
            return
        forget = self._count // 2 if self._count + more > self.MAXIMUM_POINTS else 0
        kept = self._count - forget
        # Room doubles, so the effort of copying stays in proportion to what is appended.
        room = max(more, min(max(kept + more, self.LEAST_ROOM_POINTS),
                             self.MAXIMUM_POINTS - kept))
        self._arrays = tuple(
            np.concatenate((array[forget:self._count],
                            np.empty((room, *array.shape[1:]), array.dtype)))
            for array in self._arrays)
        self._forgotten, self._count = self._forgotten + forget, kept
