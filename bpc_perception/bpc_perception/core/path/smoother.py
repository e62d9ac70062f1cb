"""Poses, averaged over a stretch of time around each."""

from __future__ import annotations

from collections.abc import Sequence
import math

import numpy as np

from bpc_perception.core.arrays import Array

LONGEST_M = 0.002  # way over which poses are averaged at most


class PoseSmoother:
    """Averages poses, and their times, over ``smoothing_time`` [s] around each.

    Uniform motion stays what it is, however unevenly poses come. Where ink is switched on or off,
    as a rule at a corner, and where the nozzle goes fast, poses are averaged over less: neither a
    stroke nor a lift is to be mixed with travel. An average is only given out when no later pose
    can change it. Sums run strictly in the order of the poses, so averages are the same to the
    last bit, however poses are split into calls.

    Nothing is averaged across a leap, see ``leaps``.

    Attributes:
        latest: time of the newest pose [s]; -inf before the first.
    """

    def __init__(self, smoothing_time: float) -> None:
        self.latest = -math.inf
        self._half = smoothing_time / 2
        self._first = math.inf  # time of the first pose
        self._new: list[tuple[float, float, float, float]] = []
        self._poses = np.empty((0, 4))  # those still needed: time, x, y, z
        self._leaps: list[tuple[float, float]] = []  # times before and after each, still needed
        self._sums = np.zeros((1, 4))  # sum of all poses before each of these
        self._smoothed = 0  # how many of these are averaged already

    @property
    def needed_since(self) -> float:
        """Time before which no switch of the ink matters any more [s]."""
        return float(self._poses[0, 0]) - self._half if len(self._poses) else -math.inf

    def add(self, time: float, tip: Array, leap: bool = False) -> None:
        """Add a position (3,) [m] at a time [s], perhaps behind a leap; times must increase."""
        x, y, z = tip.tolist()
        if leap and math.isfinite(self.latest):
            self._leaps.append((self.latest, time))
        self._new.append((time, x, y, z))
        self._first = min(self._first, time)
        self.latest = time

    def take(self, known_until: float = math.inf, switches: Sequence[float] = ()) -> Array:
        """Return the averages (N, 6) that became certain since the last call.

        The columns are mean time [s], mean x, y, z [m], the time of the pose itself [s], and 1
        for one behind a leap, else 0.

        Args:
            known_until: up to what time it is known when ink was switched on or off [s].
            switches: the times before and after which it was, increasing [s].
        """
        self._sum_up_new()
        time = self._poses[:, 0]
        if len(time) == 0:
            return np.empty((0, 6))
        until = min(time[-1], known_until)
        ready = (int(np.searchsorted(time + self._half, until, side='left')) if self._half
                 else len(time))
        centre = time[self._smoothed:ready]
        # As far back as ahead, or the path would not begin where the print does.
        reach = np.minimum(self._half, centre - self._first)
        borders = np.sort(np.concatenate((switches, *self._leaps)))
        if len(borders):
            reach = np.minimum(reach, _distance_to_nearest(centre, borders))
        reach = self._within_longest(centre, reach)
        low = np.searchsorted(time, centre - reach, side='left')
        high = np.searchsorted(time, centre + reach, side='right')
        mean = (self._sums[high] - self._sums[low]) / (high - low)[:, None]
        behind = np.isin(centre, [after for _, after in self._leaps])
        self._forget_before(ready)
        return np.column_stack((mean, centre, behind))

    def _within_longest(self, centre: Array, reach: Array) -> Array:
        """Return reaches (N,) [s], shorter where the nozzle goes far in that time."""
        time, place = self._poses[:, 0], self._poses[:, 1:4]
        low = np.searchsorted(time, centre - reach, side='left')
        high = np.searchsorted(time, centre + reach, side='right')
        way = np.linalg.norm(place[high - 1] - place[low], axis=1)
        return reach * LONGEST_M / np.maximum(way, LONGEST_M)

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
        since = self.needed_since
        self._leaps = [leap for leap in self._leaps if leap[1] >= since]
        self._smoothed = ready - keep


def _distance_to_nearest(times: Array, others: Array) -> Array:
    """Return how far (N,) times (N,) are from the nearest of others (K,), increasing."""
    after = np.searchsorted(others, times)
    padded = np.concatenate(([-np.inf], others, [np.inf]))
    return np.minimum(times - padded[after], padded[after + 1] - times)
