"""Leaps: steps between poses that the nozzle did not make.

A driver that repeats its last pose with new stamps and then recovers, or a clock that is set,
leaves one step that is far too long for the speeds before and after it. What lies between is not
known: it is no way that the nozzle went. A single pose that is wrong leaves two such steps, out
and back.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Sequence
import math
from operator import attrgetter
from typing import NamedTuple

from bpc_perception.core.arrays import Array

# A step is a leap if it is longer than the faster of its neighbours makes in this many times its
# duration, and as much more as stamps and poses are off. Poses that are repeated are less off.
FASTER = 4.0
STAMP_JITTER_S = 0.02
JITTER_M, REPEATED_JITTER_M = 0.0005, 0.0002
PATIENCE_S = 0.1  # with a doubtful pose that is given again, more than the usual time
TREMBLE_M = 2e-5  # of poses of one moment
REPEATED_M = 1e-6  # a robot that stands trembles by more
LEAPS_KEPT = 100
# Where so many and so large a share of the poses within a time are bad, none is believed, nor for
# a while after.
LEAST_BAD, BAD_SHARE, TRUST_S, CALM_S = 5, 0.04, 2.0, 1.5
LEAPT = ('pose: expected a tip that moves on evenly, found that it leapt, as when a driver '
         'repeats its last pose, a clock is set or a pose is wrong; the way it went is not '
         'known')


class Step(NamedTuple):
    """A pose, and how the nozzle got there.

    Attributes:
        stamp_ns: of the pose [ns].
        tip: (3,) position of the nozzle tip [m].
        leap: whether the way from the pose before is not known.
        wrong: whether the nozzle was not there.
    """

    stamp_ns: int
    tip: Array
    leap: bool = False
    wrong: bool = False


class _Pose(NamedTuple):
    stamp_ns: int
    tip: Array
    place: list[float]  # the same: distances between lists are found ten times as fast

    def distance(self, other: _Pose) -> float:
        """Return how far it is from another one [m]."""
        return math.dist(self.place, other.place)

    def is_at(self, other: _Pose) -> bool:
        """Return whether it is another one again."""
        return self.distance(other) <= REPEATED_M

    def step(self, leap: bool = False, wrong: bool = False) -> Step:
        """Return the step to it."""
        return Step(self.stamp_ns, self.tip, leap, wrong)

    def since(self, stamp_ns: int) -> float:
        """Return how long it is after a time [s]."""
        return (self.stamp_ns - stamp_ns) * 1e-9


class LeapFinder:
    """Tells leaps among poses, one after the other; a doubtful one waits for the next.

    A source may give each pose several times, faster than it has new ones.
    """

    def __init__(self) -> None:
        self._last: _Pose | None = None
        self._heard_ns = 0  # when it was given last
        self._speed = 0.0  # on the way to it [m/s]
        self._period = 0.0  # between it and another one before it [s]
        self._doubtful: list[_Pose] = []  # one pose, perhaps given several times

    def add(self, stamp_ns: int, tip: Array) -> list[Step]:
        """Add a position (3,) [m] at a later time [ns]; return the steps that are certain now."""
        pose = _Pose(stamp_ns, tip, tip.tolist())
        if not self._doubtful:
            return self._judge(pose)
        first = self._doubtful[0]
        if (pose.is_at(first)
                and pose.since(first.stamp_ns) < FASTER * self._period + PATIENCE_S):
            self._doubtful.append(pose)
            return []
        doubtful, self._doubtful = self._doubtful, []
        back = first.distance(pose)
        if not self._is_leap(pose, 0.0) and back > self._usual(pose.since(first.stamp_ns), 0.0):
            # A step out and one back to where it would be without it: that pose was wrong.
            self._go_to(pose)
            return [*(each.step(wrong=True) for each in doubtful), pose.step()]
        after = back / pose.since(first.stamp_ns)
        leap = self._is_leap(first, after)
        # A leap says nothing of how fast the nozzle went.
        self._go_to(first, after if leap else None)
        self._heard_ns = doubtful[-1].stamp_ns
        return [first.step(leap), *(again.step() for again in doubtful[1:]),
                *self._judge(pose)]

    def _judge(self, pose: _Pose) -> list[Step]:
        if self._last is not None and pose.is_at(self._last):
            self._heard_ns = pose.stamp_ns
        elif self._is_leap(pose, 0.0):
            self._doubtful.append(pose)
            return []
        else:
            self._go_to(pose)
        return [pose.step()]

    def _go_to(self, pose: _Pose, speed: float | None = None) -> None:
        """Take a pose as the last one, to which the nozzle went at a speed; None = find it."""
        if speed is not None:
            self._speed = speed
        elif self._last is not None:
            self._speed = pose.distance(self._last) / self._duration(pose, self._last)
            self._period = pose.since(self._last.stamp_ns)
        self._last, self._heard_ns = pose, pose.stamp_ns

    def _is_leap(self, pose: _Pose, after: float) -> bool:
        """Return whether the step to a pose is a leap, with a speed after it [m/s]."""
        if self._last is None:
            return False
        return pose.distance(self._last) > self._usual(
            self._duration(pose, self._last), after)

    def _usual(self, duration: float, after: float) -> float:
        """Return how far the nozzle goes in a time [s] at most, with a speed after it [m/s]."""
        assert self._last is not None
        repeated = self._heard_ns > self._last.stamp_ns
        return (max(self._speed, after) * (FASTER * duration + STAMP_JITTER_S)
                + (REPEATED_JITTER_M if repeated else JITTER_M))

    def _duration(self, pose: _Pose, last: _Pose) -> float:
        """Return how long the nozzle went from the last pose to this one [s], as far as known.

        Where it stood until then is the time from one message to the next, unless poses come
        anew more seldom.
        """
        return max(pose.since(self._heard_ns), min(pose.since(last.stamp_ns), self._period))


class Trust:
    """Whether the source of poses is believed.

    It is not while too many of them are wrong or leap: it seems that several publish, or one that
    mixes old poses with new ones. Then those that fit by chance are wrong as well.
    """

    def __init__(self) -> None:
        self._poses: deque[int] = deque()
        self._bad: deque[int] = deque()
        self._distrusted_until = 0

    def add(self, stamp_ns: int, bad: bool) -> bool:
        """Add a pose by its stamp [ns]; return whether it is believed if it seems good itself."""
        for stamps in (self._poses, self._bad) if bad else (self._poses,):
            stamps.append(stamp_ns)
        for stamps in (self._poses, self._bad):
            while stamps and stamp_ns - stamps[0] > TRUST_S * 1e9:
                stamps.popleft()
        many = max(LEAST_BAD, BAD_SHARE * len(self._poses))
        if bad and len(self._bad) >= many:
            self._distrusted_until = stamp_ns + round(CALM_S * 1e9)
        return stamp_ns >= self._distrusted_until


class Whereabouts:
    """When it was known where a frame is, of which poses come one after the other.

    It was not on a leap, nor while the pose before it was repeated, nor around a wrong pose.

    Attributes:
        certain_ns: stamp up to which that is told [ns]; 0 = no pose came.
    """

    def __init__(self) -> None:
        self._forget()

    def _forget(self) -> None:
        self.certain_ns = self._heard_ns = 0
        self._finder = LeapFinder()
        self._place: list[float] | None = None
        self._since_ns = 0  # when it came to that place
        self._wrong = False  # whether the last pose was
        self._unknown: deque[tuple[int, int]] = deque(maxlen=LEAPS_KEPT)

    def add(self, stamp_ns: int, place: Array) -> None:
        """Add a position (3,) [m] at a later time [ns].

        After one that is no later, the clock was set back, and nothing is known of before.
        """
        if stamp_ns <= self._heard_ns:
            self._forget()
        self._heard_ns = stamp_ns
        for step in self._finder.add(stamp_ns, place):
            if step.leap or self._wrong:
                self._unknown.append((self._since_ns, step.stamp_ns))
            self._wrong = step.wrong
            if step.wrong:
                continue
            there = step.tip.tolist()
            if self._place is None or math.dist(self._place, there) > REPEATED_M:
                self._place, self._since_ns = there, step.stamp_ns
            self.certain_ns = step.stamp_ns

    def known_at(self, stamp_ns: int) -> bool:
        """Return whether no leap is known over a time [ns]."""
        return not any(start < stamp_ns < end for start, end in self._unknown)


def contradicts(steps: Sequence[Step], stamp_ns: int, tip: Array) -> bool:
    """Return whether a late pose was not on the way that is known, as when a clock was set back.

    Args:
        steps: of the poses before, in order.
        stamp_ns: of the late pose, not later than the last of them [ns].
        tip: (3,) its position [m].
    """
    after = bisect_left(steps, stamp_ns, key=attrgetter('stamp_ns'))
    if not 0 < after < len(steps):
        return False
    start, end = steps[after - 1], steps[after]
    lasting = end.stamp_ns - start.stamp_ns
    there = start.tip + (stamp_ns - start.stamp_ns) / lasting * (end.tip - start.tip)
    speed = math.dist(start.tip, end.tip) / (lasting * 1e-9)
    return math.dist(tip, there) > speed * STAMP_JITTER_S + TREMBLE_M
