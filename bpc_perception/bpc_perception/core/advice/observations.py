"""What a print's captures and path say together: each width beside the ink that laid it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.advice.delivery_filter import (
    DEAD_TIME,
    DeliveryFilter,
    lagged,
    LAGS,
    transient_variance,
)
from bpc_perception.core.arrays import Array
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile

STEP = 1e-3  # of path that makes one observation [m]
SETTLED = 0.02  # path behind the nozzle from which no capture brings news [m]
LEAST_FLOW = 0.02  # behind a lag, as a share of the command
REACH = 3  # path points to either side over which speed and volume per length are taken
GAP_MARGIN = 1e-3  # next to a gap the bead tapers [m]
# A fall is of a delivery that was known this well before (standard deviation of the logarithm).
ESTABLISHED = 0.15
SURE = 3.0  # and by this many standard deviations
RISE, LONGEST_RISE = 0.7, 10  # a rise of the logarithm by more is ink off the path, for a while


@dataclass(frozen=True)
class Finding:
    """What the record says at the newest capture.

    Attributes:
        models: what is known of the delivery.
        flow: (L,) flow behind each lag now.
        fallen: length of the newest measured path along which much less arrives than before [m].
    """

    models: DeliveryFilter
    flow: Array
    fallen: float


class PrintRecord:
    """The path of one print as far as it is known, and the newest measurement of each point.

    Path points never change once known, so they are taken in once. Where the flow rate was not
    recorded the plunger's velocity stands for it, and where neither was, a constant: then
    ``rate_known`` is False.

    Attributes:
        command: (N,) rate commanded at each path point, 0 where no ink was to be pushed out,
            NaN where the extruder's state is unknown though it once was not.
        speed: (N,) of the nozzle [m/s].
        commanded: (N,) volume commanded per length of path.
        laying: (N,) whether ink was to be laid all around each point.
        rate_known: whether the command was recorded.
    """

    def __init__(self, path: DepositionPath, start: float = -np.inf) -> None:
        extruding = path.extruding
        self._kind = next((name for name in ('flow_rate', 'plunger_velocity')
                           if (getattr(path, name)[extruding] > 0).any()), '')
        self.rate_known = bool(self._kind)
        self._flow = np.zeros((0, len(LAGS)))  # behind each lag, at each path point
        self._width = np.zeros(0)
        self._sigma = np.zeros(0)
        self._start = start
        self._base: DeliveryFilter | None = None
        self._base_step = 0

    def take(self, path: DepositionPath, profile: ThicknessProfile) -> None:
        """Take in the path up to a capture, and what was measured in it."""
        known, count = len(self._width), len(path)
        self._path = path
        self.command = self._commands(path)
        # What is not known goes on as it was: silence is no reason to make up for anything.
        known_at = np.maximum.accumulate(
            np.where(np.isnan(self.command), 0, np.arange(count)))
        held = np.nan_to_num(self.command[known_at])
        flow = np.empty((count, len(LAGS)))
        flow[:known] = self._flow
        before = np.searchsorted(path.time, path.time - DEAD_TIME, side='right') - 1
        arriving = np.where(before < 0, 0.0, held[before])
        for index in range(known, count):
            flow[index] = 0.0 if index == 0 else lagged(
                flow[index - 1], arriving[index], path.time[index] - path.time[index - 1])
        self._flow = flow

        self.speed = per_length(path, path.arc_length, path.time)
        elapsed = np.diff(path.time, prepend=path.time[:1])
        self.commanded = per_length(
            path, np.cumsum(np.concatenate((held[:1], held[:-1])) * elapsed))
        between = (flow + np.concatenate((flow[:1], flow[:-1]))) / 2
        self._arrived = per_length(path, np.cumsum(between * elapsed[:, None], axis=0))
        # Farther off than REACH: the robot may leave before the extruder's last state is over.
        each, still = np.arange(count), np.cumsum(
            np.concatenate(([False], ~(self.command > 0))))
        pauses = (still[np.minimum(each + 2 * REACH + 1, count)]
                  - still[np.maximum(each - 2 * REACH, 0)])
        self.laying = (pauses == 0) & (self.commanded > 0) & np.isfinite(self.commanded)

        new = np.full(count - known, np.nan)
        self._width = np.concatenate((self._width, new))
        self._sigma = np.concatenate((self._sigma, new))
        place = np.searchsorted(path.time, profile.time)
        measured = profile.status == Status.MEASURED
        seen = measured | (profile.status == Status.GAP)
        self._width[place[seen]] = profile.thickness[seen]
        self._sigma[place[measured]] = profile.sigma[measured]

    def find(self, held: float, prior: float, clog_drop: float) -> Finding:
        """How much arrives.

        Args:
            held: command that the flow now is compared with.
            prior: logarithm of the gain for which the print was set up; used at first only.
            clog_drop: share of the delivery that has to be lost at once for a fall.
        """
        if self._base is None:
            self._base = DeliveryFilter(prior)
        arc = self._path.arc_length
        steps = np.floor(arc / STEP).astype(int)
        borders = np.searchsorted(steps, np.arange(self._base_step, steps[-1] + 2))
        settled = int((arc[-1] - SETTLED) / STEP)
        usable = self._usable()
        followed, low, high = self._base.branch(), 0, 0
        for offset, (start, end) in enumerate(pairwise(borders)):
            number = self._base_step + offset
            if number == settled:
                base, base_step = followed.branch(), number
            followed.move(STEP)
            chosen = start + np.flatnonzero(usable[start:end])
            if len(chosen) < 2:
                continue
            observed, flow, spread = self._observation(chosen)
            mean, sigma = followed.expect(flow, spread)
            surprise = observed - mean
            sure = (followed.gain_sigma < ESTABLISHED) and abs(surprise) > SURE * sigma
            low = low + 1 if sure and surprise < np.log1p(-clog_drop) else 0
            high = high + 1 if sure and surprise > RISE else 0
            if low == 0 and not 0 < high <= LONGEST_RISE:
                followed.update(observed, flow, spread)
        if settled > self._base_step:
            self._base, self._base_step = base, base_step
        return Finding(followed, np.maximum(self._flow[-1], LEAST_FLOW * held), low * STEP)

    def _usable(self) -> NDArray[np.bool_]:
        """Path points with a width to learn from."""
        arc = self._path.arc_length
        gap = np.flatnonzero(self._width == 0)
        near = np.zeros(len(arc) + 1)
        np.add.at(near, np.searchsorted(arc, arc[gap] - GAP_MARGIN), 1)
        np.add.at(near, np.searchsorted(arc, arc[gap] + GAP_MARGIN, side='right'), -1)
        return np.asarray((self._width > 0) & self.laying & (arc >= self._start)
                          & (np.cumsum(near)[:-1] == 0))

    def _observation(self, chosen: NDArray[np.intp]) -> tuple[float, Array, Array]:
        """Log w^2 of these points, log ink per length (L,) behind each lag, variances (L,)."""
        width, sigma = self._width[chosen], self._sigma[chosen]
        command = self.commanded[chosen].mean()
        arrived = np.maximum(self._arrived[chosen].mean(axis=0), LEAST_FLOW * command)
        noise = 2 * np.mean(sigma / width)
        return (float(np.log(np.mean(width**2))), np.log(arrived),
                noise**2 + transient_variance(arrived, command))

    def means(self, length: float) -> tuple[float, float]:
        """Speed [m/s] and command, over the time of the newest stretch where ink was laid."""
        last = int(np.flatnonzero(self.laying)[-1])
        arc = self._path.arc_length
        first = int(np.searchsorted(arc, arc[last] - length))
        breaks = np.flatnonzero(~self.laying[first:last])
        first += int(breaks[-1]) + 1 if len(breaks) else 0
        if first == last:
            return float(self.speed[last]), float(self.command[last])
        elapsed = self._path.time[first + 1:last + 1] - self._path.time[first:last]
        return (float((arc[last] - arc[first]) / elapsed.sum()),
                float((self.command[first:last] * elapsed).sum() / elapsed.sum()))

    def stalled(self, path: DepositionPath) -> bool:
        """Whether the extruder's newest state is unknown, or it stands though told to push."""
        newest = self.command[-REACH:]
        return bool(np.isnan(newest[-1]) or (
            path.extruding[-REACH:].all() and not (newest > 0).any()))

    def _commands(self, path: DepositionPath) -> Array:
        if not self._kind:
            return path.extruding.astype(float)
        rate = getattr(path, self._kind)
        return np.where(path.extruding, np.maximum(rate, 0.0), np.where(np.isnan(rate), np.nan, 0))


def per_length(path: DepositionPath, amount: Array, length: Array | None = None) -> Array:
    """How much an amount (N, ...) grows per length, around each path point.

    ``length`` (N,) is the arc length unless another is given.
    """
    length = path.arc_length if length is None else length
    index = np.arange(len(path))
    after, before = np.minimum(index + REACH, len(path) - 1), np.maximum(index - REACH, 0)
    span = length[after] - length[before]
    with np.errstate(divide='ignore', invalid='ignore'):
        return np.asarray(((amount[after] - amount[before]).T / span).T)
