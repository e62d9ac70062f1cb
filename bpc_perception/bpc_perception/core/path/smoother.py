"""Poses, averaged over a stretch of time around each."""

from __future__ import annotations

import math

import numpy as np

from bpc_perception.core.arrays import Array


class PoseSmoother:
    """Averages poses, and their times, over ``smoothing_time`` [s] around each.

    Uniform motion stays what it is, however unevenly poses come. An average is only given out
    when no later pose can change it. Sums run strictly in the order of the poses, so averages are
    the same to the last bit, however poses are split into calls.

    Attributes:
        latest: time of the newest pose [s]; -inf before the first.
    """

    def __init__(self, smoothing_time: float) -> None:
        self.latest = -math.inf
        self._half = smoothing_time / 2
        self._first = math.inf  # time of the first pose
        self._new: list[tuple[float, float, float, float]] = []
        self._poses = np.empty((0, 4))  # those still needed: time, x, y, z
        self._sums = np.zeros((1, 4))  # sum of all poses before each of these
        self._smoothed = 0  # how many of these are averaged already

    def add(self, time: float, tip: Array) -> None:
        """Add a position (3,) [m] at a time [s]; times must increase."""
        x, y, z = tip.tolist()
        self._new.append((time, x, y, z))
        self._first = min(self._first, time)
        self.latest = time

    def take(self) -> Array:
        """Return the averages (N, 5) that became certain since the last call.

        The columns are mean time [s], mean x, y, z [m], and the time of the pose itself [s].
        """
        self._sum_up_new()
        time = self._poses[:, 0]
        if len(time) == 0:
            return np.empty((0, 5))
        ready = (int(np.searchsorted(time + self._half, time[-1], side='left')) if self._half
                 else len(time))
        centre = time[self._smoothed:ready]
        # As far back as ahead, or the path would not begin where the print does.
        reach = np.minimum(self._half, centre - self._first)
        low = np.searchsorted(time, centre - reach, side='left')
        high = np.searchsorted(time, centre + reach, side='right')
        mean = (self._sums[high] - self._sums[low]) / (high - low)[:, None]
        self._forget_before(ready)
        return np.column_stack((mean, centre))

    def _sum_up_new(self) -> None:
        new = np.array(self._new).reshape(-1, 4)
        self._new.clear()
        self._poses = np.concatenate((self._poses, new))
        # Starting from the carried sum keeps the order of summation, whatever the batches.
        self._sums = np.concatenate(
            (self._sums[:-1], np.cumsum(np.concatenate((self._sums[-1:], new)), axis=0)))

    def _forget_before(self, ready: int) -> None:
        """Forget the poses that no average after the first ``ready`` poses needs."""
        time = self._poses[:, 0]
        keep = int(np.searchsorted(time, time[ready - 1] - self._half)) if ready else 0
        self._poses, self._sums = self._poses[keep:], self._sums[keep:]
        self._smoothed = ready - keep
