"""Print controllers: they turn what was measured into a factor on the nominal rate."""

from __future__ import annotations

from bisect import bisect_right
from itertools import pairwise
from typing import Protocol

import numpy as np

from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.learning.rate_schedule import RateSchedule
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets

LOG_LENGTH = 100  # changes of the factor that are remembered
SCALE_LIMITS = (0.5, 2.0)  # smallest and largest factor
# Topics of the factors on the nominal rates, std_msgs/Float64.
FLOW_SCALE, SPEED_SCALE = 'flow_rate_scale', 'speed_scale'
MEAN_WIDTH_WINDOW_M = 0.02  # of the newest path


class Controller(Protocol):
    """Sets the factor on the nominal flow rate, or on the nominal speed."""

    follows_advice: bool

    def take(self, profile: ThicknessProfile, advice: RateAdvice | None, now_ns: int) -> None:
        """Take the profile of a capture at a time [ns], and the advice if it is followed."""

    def scale(self, now_ns: int, place: float) -> float:
        """Return the factor in force at a time [ns], and at a place of the path [m]."""


class AdviceFollower:
    """Follows advice and schedule: the example of how to use both.

    The factors of an advice multiply the rate in force at its stamp. So the follower keeps a log
    of its factors: what it changed since then is not corrected a second time. Advice that is not
    valid changes nothing, but allows to keep the last factor until ``valid_until``. When no
    advice holds any more, the rate is that of the schedule, or without one the nominal, again.
    """

    follows_advice = True

    def __init__(self, actuator: str = 'flow', schedule: RateSchedule | None = None) -> None:
        if actuator not in ('flow', 'speed'):
            raise ValueError(f'actuator: expected flow or speed, found {actuator}')
        self._actuator = actuator
        self._schedule = schedule
        self._log: list[tuple[int, float]] = [(0, 1.0)]  # start of a factor [ns], factor
        self._until_ns = 0

    def take(self, profile: ThicknessProfile | None, advice: RateAdvice | None,
             now_ns: int) -> None:
        """Take an advice that came at a time [ns]; the profile is not needed."""
        del profile
        assert advice is not None
        if advice.valid_until_ns <= now_ns:
            return
        before = self._mean(advice.stamp_ns - round(advice.reference_time * 1e9),
                            advice.stamp_ns)
        if self._until_ns < now_ns:  # meanwhile the rate was nominal again
            self._set(self._until_ns, 1.0)
        self._until_ns = advice.valid_until_ns
        if advice.valid:
            scale = advice.flow_rate_scale if self._actuator == 'flow' else advice.speed_scale
            self._set(now_ns, min(max(before * scale, SCALE_LIMITS[0]), SCALE_LIMITS[1]))

    def plan(self, schedule: RateSchedule | None, now_ns: int) -> None:
        """Take a schedule that came at a time [ns]; None = there is none any more.

        It has what advice had corrected, so that the factor of the advice begins anew.
        """
        if schedule is not None:
            self._set(now_ns, 1.0)
        self._schedule = schedule

    def scale(self, now_ns: int, place: float) -> float:
        """Return the factor in force at a time [ns] and a place [m]."""
        planned = float(self._schedule.at(place)) if self._schedule else 1.0
        return min(max(planned * self._in_force(now_ns), SCALE_LIMITS[0]), SCALE_LIMITS[1])

    def _mean(self, start_ns: int, end_ns: int) -> float:
        """Return the mean of the factor over an interval [ns] that the log covers."""
        changes = [since for since, _ in self._log if start_ns < since < end_ns]
        if start_ns < self._until_ns < end_ns:
            changes = sorted((*changes, self._until_ns + 1))
        borders = (start_ns, *changes, end_ns)
        if start_ns == end_ns:
            return self._in_force(end_ns)
        return sum(self._in_force(start) * (end - start)
                   for start, end in pairwise(borders)) / (end_ns - start_ns)

    def _in_force(self, at_ns: int) -> float:
        """Return the factor in force at a time [ns]; 1 when no advice holds any more."""
        if at_ns > self._until_ns:
            return 1.0
        following = bisect_right(self._log, at_ns, key=lambda entry: entry[0])
        return self._log[max(following, 1) - 1][1]

    def _set(self, since_ns: int, scale: float) -> None:
        """Put a factor in force from a time on [ns]."""
        self._log.append((since_ns, scale))
        del self._log[:-LOG_LENGTH]


class NoFeedback:
    """Prints at the nominal rate."""

    follows_advice = False

    def take(self, profile: ThicknessProfile, advice: RateAdvice | None, now_ns: int) -> None:
        """Ignore the measurement."""

    def scale(self, now_ns: int, place: float) -> float:
        """Return 1."""
        del now_ns, place
        return 1.0


class ScheduleFollower:
    """Follows a schedule alone."""

    follows_advice = False

    def __init__(self, schedule: RateSchedule | None) -> None:
        self._schedule = schedule

    def take(self, profile: ThicknessProfile, advice: RateAdvice | None, now_ns: int) -> None:
        """Ignore the measurement."""

    def scale(self, now_ns: int, place: float) -> float:
        """Return the factor at a place [m]."""
        del now_ns
        return float(self._schedule.at(place)) if self._schedule else 1.0


def mean_width_ratio(profile: ThicknessProfile, targets: WidthTargets) -> float:
    """Return the mean of measured over wanted width in the newest 20 mm of path.

    NaN where nothing was measured.
    """
    if not len(profile):
        return np.nan
    newest = profile.arc_length >= profile.arc_length[-1] - MEAN_WIDTH_WINDOW_M
    chosen = newest & profile.extruding & (profile.status == Status.MEASURED)
    if not chosen.any():
        return np.nan
    return float((profile.thickness[chosen] / targets.at(profile.arc_length[chosen])).mean())


class MassBalance:
    """Applies (target / mean width)^2 to the present rate at every capture, at once."""

    follows_advice = False

    def __init__(self, targets: WidthTargets) -> None:
        self._targets = targets
        self._scale = 1.0

    def take(self, profile: ThicknessProfile, advice: RateAdvice | None, now_ns: int) -> None:
        """Correct by the mean width of this capture."""
        del advice, now_ns
        ratio = mean_width_ratio(profile, self._targets)
        if np.isfinite(ratio):
            self._scale = float(np.clip(self._scale / ratio**2, *SCALE_LIMITS))

    def scale(self, now_ns: int, place: float) -> float:
        """Return the factor in force."""
        del now_ns, place
        return self._scale


class ProportionalIntegral:
    """A PI controller on the mean width; its integral is held while the factor is limited.

    The gains have the least mean of the squared width error, relative to no feedback, over the
    scenarios without a fault, on seeds of their own (``bpc_sim.studies.closed_loop.tuning``).
    """

    follows_advice = False

    def __init__(self, targets: WidthTargets, proportional: float = 0.6,
                 integral: float = 0.15) -> None:
        self._targets = targets
        self._proportional_gain, self._integral_gain = proportional, integral
        self._integral = 0.0
        self._scale = 1.0
        self._last_ns: int | None = None

    def take(self, profile: ThicknessProfile, advice: RateAdvice | None, now_ns: int) -> None:
        """Advance by one capture."""
        del advice, now_ns
        error = 1 - mean_width_ratio(profile, self._targets)
        if not np.isfinite(error):
            return
        elapsed = 0.0 if self._last_ns is None else (profile.stamp_ns - self._last_ns) * 1e-9
        self._last_ns = profile.stamp_ns
        integral = self._integral + self._integral_gain * error * elapsed
        wanted = 1 + self._proportional_gain * error + integral
        self._scale = float(np.clip(wanted, *SCALE_LIMITS))
        if self._scale == wanted:
            self._integral = integral

    def scale(self, now_ns: int, place: float) -> float:
        """Return the factor in force."""
        del now_ns, place
        return self._scale
