"""From poses and extruder states to the path of a print, while it grows.

The same inputs give the same path to the last bit, however they are split into calls: live and
offline measurements have to agree. Hence sums run strictly in order, and a path point is
only given out when nothing that arrives later can change it.
"""

from __future__ import annotations

from bisect import bisect_right
import math

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import PathConfig
from bpc_perception.core.extruder.sample import ExtruderSample
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.growing_path import GrowingPath

MAXIMUM_STATES = 100_000  # of the extruder that wait for poses


class PathAssembler:
    """The path of one print: smoothed, resampled, joined with the extruder's state.

    Poses are averaged over ``smoothing_time`` around each, and so are their times, so that
    uniform motion stays what it is however unevenly poses come. Path points are placed along
    their polyline each ``spacing`` away from the one before, so that a robot that trembles on
    the spot adds no length.
    """

    def __init__(self, path: GrowingPath, config: PathConfig) -> None:
        """Append to a path: an empty one, or one that was left off."""
        self.start_ns = path.start_ns
        self._config = config
        self._stop = math.inf
        self._new: list[tuple[float, float, float, float]] = []
        self._tail = np.empty((0, 4))  # poses still needed: time, x, y, z
        self._sums = np.zeros((1, 4))  # sum of all poses before each of the tail
        self._first: float | None = None  # time of the first pose
        self._smoothed = 0  # poses of the tail already smoothed
        # Smoothed poses from the last path point on; last, the time of the pose itself.
        self._knots = np.empty((0, 5))
        self._scanned = 0  # knots known to be nearer than `spacing` to the last path point
        self._waiting: list[tuple[float, float, float, float, float]] = []
        self._states: list[ExtruderSample] = []
        self._state_times: list[float] = []
        self._path = path

    def add_pose(self, stamp_ns: int, tip: Array) -> None:
        """Append a position (3,) of the nozzle tip [m]; stamps must increase."""
        time = self._time(stamp_ns)
        if self._path.finished or time <= self._path.complete_until:  # of a path left off
            return
        x, y, z = tip.tolist()
        self._new.append((time, x, y, z))

    def add_extruder(self, sample: ExtruderSample) -> None:
        """Append a state of the extruder; stamps must increase."""
        if self._path.finished:
            return
        time = self._time(sample.stamp_ns)
        if time < self._latest() - self._config.extrusion_timeout:
            # Too late for points given up by now, whether or not anyone has asked for them.
            self._advance()
        self._states.append(sample)
        self._state_times.append(time)
        if len(self._states) > MAXIMUM_STATES:  # no poses come that would use them up
            del self._states[:MAXIMUM_STATES // 2], self._state_times[:MAXIMUM_STATES // 2]

    def stop(self, stamp_ns: int) -> None:
        """Let the path end at this time, or where it is complete if that is later."""
        self._advance()
        self._stop = max(self._time(stamp_ns), self._path.complete_until)

    def path(self) -> DepositionPath:
        """The path as far as it is certain by now."""
        return self.growing_path().path()

    def growing_path(self) -> GrowingPath:
        """The same, of which later calls can ask for what is new."""
        self._advance()
        return self._path

    def _advance(self) -> None:
        """Give out what is certain by now."""
        if self._path.finished:
            return
        latest = self._latest()
        self._smooth()
        self._resample()
        complete = self._join(latest)
        # That of a path left off may be later than the first poses heard since.
        self._path.complete_until = max(self._path.complete_until, min(complete, self._stop))
        self._path.finished = complete >= self._stop

    def _latest(self) -> float:
        if self._new:
            return self._new[-1][0]
        return float(self._tail[-1, 0]) if len(self._tail) else -math.inf

    def _time(self, stamp_ns: int) -> float:
        return (stamp_ns - self.start_ns) * 1e-9

    def _smooth(self) -> None:
        """Turn the poses whose neighbourhood is complete into knots."""
        new = np.array(self._new).reshape(-1, 4)
        self._new.clear()
        self._tail = np.concatenate((self._tail, new))
        # Starting from the carried sum keeps the order of summation, whatever the batches.
        self._sums = np.concatenate(
            (self._sums[:-1], np.cumsum(np.concatenate((self._sums[-1:], new)), axis=0)))
        time = self._tail[:, 0]
        if len(time) == 0:
            return
        half = self._config.smoothing_time / 2
        ready = int(np.searchsorted(time + half, time[-1], side='left')) if half else len(time)
        centre = slice(self._smoothed, ready)
        if self._first is None:
            self._first = float(time[0])
        # As far back as ahead, or the path would not begin where the print does.
        reach = np.minimum(half, time[centre] - self._first)
        low = np.searchsorted(time, time[centre] - reach, side='left')
        high = np.searchsorted(time, time[centre] + reach, side='right')
        mean = (self._sums[high] - self._sums[low]) / (high - low)[:, None]
        self._knots = np.concatenate((self._knots, np.column_stack((mean, time[centre]))))
        keep = int(np.searchsorted(time, time[ready - 1] - half)) if ready else 0
        self._tail, self._sums = self._tail[keep:], self._sums[keep:]
        self._smoothed = ready - keep

    def _resample(self) -> None:
        """Place path points along the knots, each ``spacing`` from the one before."""
        knots, spacing = self._knots, self._config.spacing
        if len(knots) and not self._waiting and not len(self._path):
            self._waiting.append((knots[0, 0], 0.0, *knots[0, 1:4]))
        while self._scanned < len(knots):
            last = np.array(self._waiting[-1]) if self._waiting else self._path.last()
            block = knots[self._scanned:self._scanned + 256]
            offset = block[:, 1:4] - last[2:]
            away = np.flatnonzero((offset * offset).sum(axis=1) >= spacing * spacing)
            if len(away) == 0:
                self._scanned += len(block)
                continue
            self._scanned += int(away[0])
            self._waiting.append(self._step(last, self._scanned))
        keep = max(self._scanned - 1, 0)
        self._knots, self._scanned = knots[keep:], self._scanned - keep

    def _step(self, last: Array, index: int) -> tuple[float, float, float, float, float]:
        """The next path point, between the knots before and at ``index``."""
        # Before the first knot of a path left off nothing is known.
        gap = self._knots[index, 4] - self._knots[index - 1, 4] if index else math.inf
        start, end = self._knots[index - 1, :4], self._knots[index, :4]
        step = end[1:] - start[1:]
        if gap > self._config.maximum_gap:
            arc = last[1] + math.dist(last[2:], end[1:])
            return (end[0], arc, *end[1:])
        # |start + share * step - last| = spacing, a quadratic in share.
        back = start[1:] - last[2:]
        a, b = float((step * step).sum()), float((step * back).sum())
        c = float((back * back).sum()) - self._config.spacing ** 2
        share = min(max((-b + math.sqrt(max(b * b - a * c, 0.0))) / a, 0.0), 1.0)
        time = start[0] + share * (end[0] - start[0])
        return (time, last[1] + self._config.spacing, *(start[1:] + share * step))

    def _join(self, latest: float) -> float:
        """Give out the points whose extruder state is known or given up; complete until when."""
        timeout = self._config.extrusion_timeout
        known = self._state_times[-1] if self._state_times else -math.inf
        knot = float(self._knots[-1, 0]) if len(self._knots) else -math.inf
        complete = min(knot, max(known, latest - timeout))
        rows = []
        for point in self._waiting:
            if point[0] > min(complete, self._stop):
                break
            before = bisect_right(self._state_times, point[0]) - 1
            if before >= 0 and point[0] - self._state_times[before] <= timeout:
                state = self._states[before]
                rows.append((*point, state.plunger_velocity, state.flow_rate, state.extruding))
            else:
                rows.append((*point, math.nan, math.nan, False))
        if rows:
            del self._waiting[:len(rows)]
            time, arc, x, y, z, velocity, flow, extruding = np.array(rows).T
            self._path.append(time, arc, np.stack((x, y, z), axis=1), velocity, flow,
                              extruding.astype(bool))
        forgotten = max(bisect_right(self._state_times, complete) - 1, 0)
        del self._states[:forgotten], self._state_times[:forgotten]
        return complete
