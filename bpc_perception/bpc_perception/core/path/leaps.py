"""Leaps: steps between poses that the nozzle did not make.

A driver that repeats its last pose with new stamps and then recovers, or a clock that is set,
leaves one step that is far too long for the speeds before and after it. What lies between is not
known: it is no way that the nozzle went.
"""

from __future__ import annotations

from collections import deque
import math
from typing import NamedTuple

from bpc_perception.core.arrays import Array

# A step is a leap if it is longer than the faster of its neighbours makes in this many times its
# duration, and as much more as stamps and poses are off.
FASTER = 4.0
STAMP_JITTER_S = 0.02
JITTER_M = 0.0005
REPEATED_M = 1e-6  # a robot that stands trembles by more
LEAPS_KEPT = 100
LEAPT = ('pose: expected a tip that moves on evenly, found that it leapt, as when a driver '
         'repeats its last pose or a clock is set; the way it went is not known')


class Step(NamedTuple):
    """A pose, and how the nozzle got there.

    Attributes:
        stamp_ns: of the pose [ns].
        tip: (3,) position of the nozzle tip [m].
        leap: whether the way from the pose before is not known.
    """

    stamp_ns: int
    tip: Array
    leap: bool


class LeapFinder:
    """Tells leaps among poses, one after the other; a doubtful one waits for the next."""

    def __init__(self) -> None:
        self._last: tuple[int, Array] | None = None
        self._speed = 0.0  # before the last pose [m/s]
        self._doubtful: tuple[int, Array] | None = None

    def add(self, stamp_ns: int, tip: Array) -> list[Step]:
        """Add a position (3,) [m] at a later time [ns]; return the steps that are certain now."""
        found: list[Step] = []
        if self._doubtful is not None:
            doubtful, self._doubtful = self._doubtful, None
            after = _speed(doubtful, (stamp_ns, tip))
            leap = self._is_leap(doubtful, after)
            # A leap says nothing of how fast the nozzle went.
            self._take(doubtful, after if leap else None)
            found.append(Step(*doubtful, leap))
        if self._is_leap((stamp_ns, tip), 0.0):
            self._doubtful = (stamp_ns, tip)
        else:
            self._take((stamp_ns, tip), None)
            found.append(Step(stamp_ns, tip, False))
        return found

    def _take(self, pose: tuple[int, Array], speed: float | None) -> None:
        if speed is None:
            speed = _speed(self._last, pose) if self._last is not None else 0.0
        self._last, self._speed = pose, speed

    def _is_leap(self, pose: tuple[int, Array], after: float) -> bool:
        """Return whether the step to a pose is a leap, with a speed after it [m/s]."""
        if self._last is None:
            return False
        duration = (pose[0] - self._last[0]) * 1e-9
        usual = max(self._speed, after) * (FASTER * duration + STAMP_JITTER_S) + JITTER_M
        return math.dist(self._last[1], pose[1]) > usual


class Whereabouts:
    """When it was known where a frame is, of which poses come one after the other.

    It was not on a leap, nor while the pose before it was repeated.

    Attributes:
        certain_ns: stamp up to which that is told [ns]; 0 = no pose came.
    """

    def __init__(self) -> None:
        self.certain_ns = 0
        self._finder = LeapFinder()
        self._place: Array | None = None
        self._since_ns = 0  # when it came to that place
        self._unknown: deque[tuple[int, int]] = deque(maxlen=LEAPS_KEPT)

    def add(self, stamp_ns: int, place: Array) -> None:
        """Add a position (3,) [m] at a later time [ns]."""
        for step in self._finder.add(stamp_ns, place):
            if step.leap:
                self._unknown.append((self._since_ns, step.stamp_ns))
            if self._place is None or math.dist(self._place, step.tip) > REPEATED_M:
                self._place, self._since_ns = step.tip, step.stamp_ns
            self.certain_ns = step.stamp_ns

    def known_at(self, stamp_ns: int) -> bool:
        """Return whether no leap is known over a time [ns]."""
        return not any(start < stamp_ns < end for start, end in self._unknown)


def _speed(start: tuple[int, Array], end: tuple[int, Array]) -> float:
    return math.dist(start[1], end[1]) / ((end[0] - start[0]) * 1e-9)
