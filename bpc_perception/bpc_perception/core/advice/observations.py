"""What a print's captures and path say together: each width beside the ink that laid it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from bpc_perception.core.advice.delivery_filter import (
    DeliveryFilter,
    LAGS_S,
    PRIOR_SIGMA,
    transient_variance,
)
from bpc_perception.core.advice.laid import (
    commanded_rates,
    flow_behind_lags,
    held_rates,
    Laid,
    laid_along,
    per_length,
    RATES,
    REACH,
    recorded_rate,
)
from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import near_any
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile

OBSERVATION_LENGTH_M = 1e-3  # of path that makes one observation
# Samples that tell whether volumes can be compared, and between which shares of what was commanded
# they lie if so: an extruder that is calibrated.
LEAST_AREAS, LEAST_VOLUME, MOST_VOLUME = 25, 0.7, 1.4
LEAST_PLANNED_SIGMA = 0.1  # of the gain under a schedule: the ink may be another
SPEED_S = 0.8  # over which the speed in force is taken: a glitch of stamps is shorter
FOLLOWING_S = 10.0  # in which flow and speed are compared: the flow follows if the volume per
FOLLOWING = 0.5  # length varies less than the flow by this factor
SPEED_LOST_S = 1.5  # without a steady way, after which it is not known
SETTLED_M = 0.02  # path behind the nozzle from which no capture brings news
LEAST_FLOW = 0.02  # behind a lag, as a share of the command
GAP_MARGIN_M = 1e-3  # next to a gap the bead tapers
# A fall is of a delivery that was known this well before (standard deviation of the logarithm),
ESTABLISHED_SIGMA = 0.15
SURE_SIGMAS = 3.0  # and by this many standard deviations.
RISE = 0.7  # a rise of the logarithm by more is ink off the path,
LONGEST_RISE = 10  # for at most this number of observations


@dataclass(frozen=True)
class Finding:
    """What the observations say at the newest capture.

    Attributes:
        models: what is known of the delivery.
        flow: (L,) flow behind each lag now.
        fallen: length of the newest measured path along which much less arrives than before [m].
    """

    models: DeliveryFilter
    flow: Array
    fallen: float


@dataclass(frozen=True)
class _Observation:
    """A width and the ink that laid it, over a short length of path.

    Attributes:
        log_area: logarithm of w^2.
        flow: (L,) logarithm of the ink per length behind each lag.
        variance: (L,) of what is observed, for each lag.
    """

    log_area: float
    flow: Array
    variance: Array


class Observations:
    """The path of one print as far as it is known, and the newest measurement of each point.

    Path points never change once known, so they are taken in once. Where the flow rate was not
    recorded the plunger's velocity stands for it, and where neither was, a constant.

    Args:
        path: of the print.
        start: arc length before which nothing is learned [m].
        by_area: whether the area of the cross-section is observed, instead of the width.
        planned_sigma: of the logarithm of what a schedule makes of the ink along the path; it
            fills the lag after each pause. None = there is no schedule.

    Attributes:
        rate_known: whether the command was recorded.
        laid: what the path says of the ink.
    """

    def __init__(self, path: DepositionPath, start: float = -np.inf,
                 by_area: bool = False, planned_sigma: float | None = None) -> None:
        self._by_area = by_area
        self._planned = planned_sigma is not None
        self._prior_sigma = (PRIOR_SIGMA if planned_sigma is None else
                             min(max(planned_sigma, LEAST_PLANNED_SIGMA), PRIOR_SIGMA))
        self._rate = recorded_rate(path)
        self.rate_known = bool(self._rate)
        self._path = path.where(np.zeros(len(path), bool))
        self._flow = np.zeros((0, len(LAGS_S)))  # behind each lag, at each path point
        none = np.zeros(0)
        never = np.zeros(0, bool)
        self.laid = Laid(none, none, none, self._flow, none, never, never, never)
        self._width = none
        self._sigma = none
        self._start = start
        self._settled: DeliveryFilter | None = None  # what settled observations have taught
        self._settled_number = 0  # of the first observation that is not settled

    def take(self, path: DepositionPath, profile: ThicknessProfile,
             others: Observations | None = None) -> None:
        """Take in the path up to a capture, and what was measured in it.

        Others of this print that have done so tell what the path says of the ink.
        """
        self._path = path
        if others is not None and others._rate == self._rate:
            self._flow, self.laid = others._flow, others.laid
        else:
            self._take_command(path, (profile.stamp_ns - path.start_ns) * 1e-9)
        self._take_widths(profile)

    def _take_command(self, path: DepositionPath, until: float) -> None:
        rate = commanded_rates(path, self._rate)
        if not self._planned:
            held = held_rates(rate)
            self._flow = flow_behind_lags(path, held, self._flow)
            self.laid = laid_along(path, rate, held, self._flow, until)
            return
        # The schedule leads the command for the lag, at each pause and change of speed. So what is
        # behind a lag is what is commanded beside the schedule, per length of path.
        speed = per_length(path, path.arc_length, path.time)
        held = held_rates(np.where((rate > 0) & (speed > 0), rate, np.nan))
        volume = held_rates(np.where((rate > 0) & (speed > 0), rate / speed, np.nan))
        self._flow = flow_behind_lags(path, volume, self._flow, under_way=True)
        self.laid = replace(laid_along(path, rate, held, self._flow, until), arrived=self._flow)

    def _take_widths(self, profile: ThicknessProfile) -> None:
        new = np.full(len(self._path) - len(self._width), np.nan)
        self._width = np.concatenate((self._width, new))
        self._sigma = np.concatenate((self._sigma, new))
        place = np.searchsorted(self._path.time, profile.time)
        measured = profile.status == Status.MEASURED
        seen = measured | (profile.status == Status.GAP)
        values, sigma = ((profile.area, profile.area_sigma) if self._by_area
                         else (profile.thickness, profile.sigma))
        self._width[place[seen]] = values[seen]
        self._sigma[place[measured]] = sigma[measured]

    def find(self, held: float, prior: float, clog_drop: float) -> Finding:
        """Find how much arrives.

        Args:
            held: command that the flow now is compared with.
            prior: logarithm of the gain for which the print was set up; used at first only.
            clog_drop: share of the delivery that has to be lost at once for a fall.
        """
        settled = self._settled = self._settled or DeliveryFilter(prior, self._prior_sigma)
        laid = self.laid.length
        numbers = np.floor(laid / OBSERVATION_LENGTH_M).astype(int)
        borders = np.searchsorted(numbers, np.arange(self._settled_number, numbers[-1] + 2))
        last_settled = int((laid[-1] - SETTLED_M) / OBSERVATION_LENGTH_M)
        usable = self._usable()
        follower = _Follower(settled.branch(), clog_drop)
        for number, (start, end) in enumerate(pairwise(borders), self._settled_number):
            if number == last_settled:
                settled = follower.models.branch()
            follower.models.move(OBSERVATION_LENGTH_M)
            chosen = start + np.flatnonzero(usable[start:end])
            if len(chosen) >= 2:
                follower.follow(self._observe(chosen, prior))
        if last_settled > self._settled_number:
            self._settled, self._settled_number = settled, last_settled
        # Under a schedule it is per length of path.
        last = int(np.flatnonzero(self.laid.laying)[-1])
        flow = self._flow[-1] * (self.in_force(last)[1] if self._planned else 1.0)
        return Finding(follower.models, np.maximum(flow, LEAST_FLOW * held),
                       follower.low * OBSERVATION_LENGTH_M)

    def _usable(self) -> Flags:
        """Return which path points (N,) have a width to learn from."""
        arc = self._path.arc_length
        near = near_any(arc, arc[self._width == 0], GAP_MARGIN_M)
        laid = self.laid
        return np.asarray((self._width > 0) & laid.laying & laid.steady & laid.under_way
                          & (arc >= self._start) & ~near)

    def is_volume(self) -> bool:
        """Return whether what is commanded is about the volume that is seen, and not a rate only.

        Else nobody can say from the area of the ink alone whether it is too much.
        """
        area, volume = self._width, self.laid.volume
        known = (area > 0) & self.laid.laying & self.laid.steady
        if self._rate != RATES[0] or known.sum() < LEAST_AREAS:
            return False
        return bool(LEAST_VOLUME < np.median(area[known] / volume[known]) < MOST_VOLUME)

    def _observe(self, chosen: Index, prior: float) -> _Observation:
        """Return what the path points of an index (K,) say together."""
        width, sigma = self._width[chosen], self._sigma[chosen]
        volume = self.laid.volume[chosen].mean()
        arrived = np.maximum(self.laid.arrived[chosen].mean(axis=0), LEAST_FLOW * volume)
        relative = np.mean(sigma / width)
        # Of an area the gain is the share that arrives, which is 1 as the print was set up.
        log_area, noise = ((np.log(width.mean()) + prior, relative) if self._by_area
                           else (np.log(np.mean(width**2)), 2 * relative))
        return _Observation(float(log_area), np.log(arrived),
                            noise**2 + transient_variance(arrived, volume))

    def in_force(self, last: int) -> tuple[float, float]:
        """Return the command at the last point that is laid: volume per length, and speed [m/s].

        The speed is that of the last moments in which the nozzle neither left nor arrived: that of
        an instant may be a corner, or poses whose stamps are off.
        """
        laid, time = self.laid, self._path.time
        steady = np.flatnonzero(laid.laying & laid.steady)
        if not len(steady):
            return float(laid.volume[last]), float(laid.speed[last])
        newest = steady[(time[steady] > time[steady[-1]] - SPEED_S)
                        | (steady > steady[-1] - REACH)]
        speed = float(np.median(laid.speed[newest]))
        if self._follows_speed(steady):
            return float(laid.volume[steady[-1]]), speed
        return float(laid.volume[last] * laid.speed[last]) / speed, speed

    def _follows_speed(self, steady: Index) -> bool:
        """Return whether the flow changes with the speed of late, as at corners.

        Args:
            steady: the points at which both are known.
        """
        newest = steady[self._path.time[steady] > self._path.time[steady[-1]] - FOLLOWING_S]
        volume = np.log(self.laid.volume[newest])
        rate = volume + np.log(self.laid.speed[newest])
        return bool(volume.std() < FOLLOWING * rate.std())

    def speed_known(self, path: DepositionPath) -> bool:
        """Return whether it is known how fast the nozzle went of late, where it laid ink.

        It need not be known in a stroke too short for that, if it was in those before.
        """
        laying = np.flatnonzero(self.laid.laying)
        steady = laying[self.laid.steady[laying]]
        if not len(steady):
            return True
        since = laying[laying > steady[-1]]
        elapsed = np.diff(path.time, prepend=path.time[:1])
        return bool(elapsed[since].sum() <= SPEED_LOST_S)

    def means(self, length: float) -> tuple[float, float]:
        """Return mean speed [m/s] and rate over the newest stretch [m] where ink was laid."""
        laid, arc = self.laid, self._path.arc_length
        last = int(np.flatnonzero(laid.laying)[-1])
        first = int(np.searchsorted(arc, arc[last] - length))
        breaks = np.flatnonzero(~laid.laying[first:last])
        first += int(breaks[-1]) + 1 if len(breaks) else 0
        if first == last:
            return float(laid.speed[last]), float(laid.rate[last])
        elapsed = self._path.time[first + 1:last + 1] - self._path.time[first:last]
        return (float((arc[last] - arc[first]) / elapsed.sum()),
                float((laid.rate[first:last] * elapsed).sum() / elapsed.sum()))

    def stalled(self, path: DepositionPath) -> bool:
        """Return whether the extruder's state is unknown, or it stands though told to push."""
        newest = self.laid.rate[-REACH:]
        if not len(newest):
            return False
        return bool(np.isnan(newest[-1]) or (
            path.extruding[-REACH:].all() and not (newest > 0).any()))


class _Follower:
    """Follows the delivery from one observation to the next.

    Attributes:
        models: what is known by now.
        low: number of observations in a row of much less ink than before.
    """

    def __init__(self, models: DeliveryFilter, clog_drop: float) -> None:
        self.models = models
        self.low = 0
        self._high = 0
        self._fall = np.log1p(-clog_drop)

    def follow(self, seen: _Observation) -> None:
        """Learn from an observation, unless the delivery has fallen, or ink lies off the path."""
        mean, sigma = self.models.expect(seen.flow, seen.variance)
        surprise = seen.log_area - mean
        sure = (self.models.gain_sigma < ESTABLISHED_SIGMA
                and abs(surprise) > SURE_SIGMAS * sigma)
        self.low = self.low + 1 if sure and surprise < self._fall else 0
        self._high = self._high + 1 if sure and surprise > RISE else 0
        if self.low == 0 and not 0 < self._high <= LONGEST_RISE:
            self.models.update(seen.log_area, seen.flow, seen.variance)
