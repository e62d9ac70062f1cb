"""Path points, joined with what the extruder did."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Iterable
from dataclasses import replace
from itertools import takewhile
import math

import numpy as np

from bpc_perception.core.extruder.sample import ExtruderSample
from bpc_perception.core.path.growing_path import GrowingPath
from bpc_perception.core.path.resampler import PathPoint

MAXIMUM_WAITING_STATES = 100_000  # of the extruder, that wait for poses
UNKNOWN_STATE = ExtruderSample(0, False, math.nan, math.nan)


class ExtruderJoiner:
    """Gives each path point the state of the extruder that held when the nozzle passed.

    A state holds until the next, but for no longer than ``timeout`` [s]. Points wait until their
    state is known.
    """

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._points: list[PathPoint] = []
        self._states: list[ExtruderSample] = []
        self._state_times: list[float] = []
        self._switches: deque[float] = deque()
        # What the newest state says, and its time.
        self._extruding: bool | None = None
        self._latest = -math.inf

    def add_state(self, time: float, state: ExtruderSample) -> None:
        """Add a state at a time [s]; times must increase."""
        if self._extruding is not None and state.extruding != self._extruding:
            # It was between the two states.
            self._switches.extend((self._latest, time))
        self._extruding, self._latest = state.extruding, time
        self._states.append(state)
        self._state_times.append(time)
        if len(self._states) > MAXIMUM_WAITING_STATES:  # no poses come that would use them up
            self._forget_states(MAXIMUM_WAITING_STATES // 2)

    def add_points(self, points: Iterable[PathPoint]) -> None:
        """Add the next points of the path."""
        self._points.extend(points)

    def switches(self, since: float) -> list[float]:
        """Return between what times ink was switched, after a time [s]; forget those before."""
        while self._switches and self._switches[0] < since:
            self._switches.popleft()
        return list(self._switches)

    def known_until(self, latest_pose: float) -> float:
        """Return up to what time states are known, or given up [s].

        They are given up one timeout before the latest pose [s].
        """
        newest = self._state_times[-1] if self._state_times else -math.inf
        return max(newest, latest_pose - self._timeout)

    def join(self, until: float, path: GrowingPath) -> None:
        """Append the waiting points up to a time [s] to the path, each with its state."""
        points = list(takewhile(lambda point: point.time <= until, self._points))
        if points:
            del self._points[:len(points)]
            states = [self._state_at(point.time) for point in points]
            path.append(
                time=np.array([point.time for point in points]),
                arc_length=np.array([point.arc_length for point in points]),
                points=np.array([point.position for point in points]),
                plunger_velocity=np.array([state.plunger_velocity for state in states]),
                flow_rate=np.array([state.flow_rate for state in states]),
                extruding=np.array([state.extruding for state in states]),
                extruder_known=np.array([state is not UNKNOWN_STATE for state in states]))
        self._forget_states(max(bisect_right(self._state_times, until) - 1, 0))

    def _state_at(self, time: float) -> ExtruderSample:
        before = bisect_right(self._state_times, time) - 1
        if before >= 0 and time - self._state_times[before] <= self._timeout:
            return _slower(self._states[before], *self._states[before + 1:before + 2])
        return UNKNOWN_STATE

    def _forget_states(self, count: int) -> None:
        del self._states[:count], self._state_times[:count]


def _slower(state: ExtruderSample, following: ExtruderSample | None = None) -> ExtruderSample:
    """Return a state of pushing with the lower rates of it and the following, if that pushes too.

    At the start of a stroke the plunger has just made up for a retraction, fast. The last state of
    that is not how ink is laid where the nozzle leaves.
    """
    if following is None or not (state.extruding and following.extruding):
        return state
    return replace(
        state, plunger_velocity=min(state.plunger_velocity, following.plunger_velocity),
        flow_rate=min(state.flow_rate, following.flow_rate))
