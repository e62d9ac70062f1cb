"""Print controllers: what makes a factor on the nominal rate of what was measured."""

from __future__ import annotations

from bisect import bisect_right
from itertools import pairwise
from typing import Protocol

import numpy as np

from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.profile import Status, ThicknessProfile

LOG = 100  # changes of the factor that are remembered
LIMITS = (0.5, 2.0)  # of the factor
# Topics of the factors on the nominal rates, std_msgs/Float64.
FLOW_SCALE, SPEED_SCALE = 'flow_rate_scale', 'speed_scale'
WINDOW = 0.02  # of path, newest, that the mean width is taken of [m]


class Controller(Protocol):
    """Sets the factor on the nominal flow rate, or on the nominal speed."""

    follows_advice: bool

    def take(self, profile: ThicknessProfile, advice: RateAdvice | None, now_ns: int) -> None:
        """Take what came of a capture, at this time [ns]; advice, if it follows that."""

    def scale(self, now_ns: int) -> float:
        """The factor in force at this time [ns]."""


class AdviceFollower:
    """Follows advice to the letter: the example of a consumer of ``rate_advice``.

    The factors of an advice are on the rate in force at its stamp. Hence it keeps a log of what
    it had in force when: what it changed since then is not corrected a second time. Advice that
    is not valid changes nothing, but as long as it holds the last factor may be kept. When
    nothing holds any more the rate is the nominal one again.
    """

    follows_advice = True

    def __init__(self, actuator: str = 'flow') -> None:
        if actuator not in ('flow', 'speed'):
            raise ValueError(f'actuator: expected flow or speed, found {actuator}')
        self._actuator = actuator
        self._log: list[tuple[int, float]] = [(0, 1.0)]  # since when which factor
        self._until_ns = 0

    def take(self, profile: ThicknessProfile | None, advice: RateAdvice | None,
             now_ns: int) -> None:
        """Take an advice that came at this time [ns]; the profile is not needed."""
        del profile
        assert advice is not None
        if advice.valid_until_ns <= now_ns:
            return
        before = self._mean(advice.stamp_ns - round(advice.reference_time * 1e9),
                            advice.stamp_ns)
        if self._until_ns < now_ns:  # it has gone back to nominal meanwhile
            self._set(self._until_ns, 1.0)
        self._until_ns = advice.valid_until_ns
        if advice.valid:
            scale = advice.flow_rate_scale if self._actuator == 'flow' else advice.speed_scale
            self._set(now_ns, min(max(before * scale, LIMITS[0]), LIMITS[1]))

    def scale(self, now_ns: int) -> float:
        """The factor in force at this time [ns]."""
        return self._in_force(now_ns)

    def _mean(self, start_ns: int, end_ns: int) -> float:
        """Mean of the factor over a time [ns], of which the log is long enough."""
        changes = [since for since, _ in self._log if start_ns < since < end_ns]
        if start_ns < self._until_ns < end_ns:
            changes = sorted((*changes, self._until_ns + 1))
        borders = (start_ns, *changes, end_ns)
        if start_ns == end_ns:
            return self._in_force(end_ns)
        return sum(self._in_force(start) * (end - start)
                   for start, end in pairwise(borders)) / (end_ns - start_ns)

    def _in_force(self, at_ns: int) -> float:
        if at_ns > self._until_ns:
            return 1.0
        return self._log[max(bisect_right(self._log, at_ns, key=lambda entry: entry[0]), 1) - 1][1]

    def _set(self, since_ns: int, scale: float) -> None:
        self._log.append((since_ns, scale))
        del self._log[:-LOG]


class NoFeedback:
    """Prints at the nominal rate."""

    follows_advice = False

    def take(self, profile: ThicknessProfile, advice: RateAdvice | None, now_ns: int) -> None:
        """Nothing is made of it."""

    def scale(self, now_ns: int) -> float:
        """Always 1."""
        del now_ns
        return 1.0


def deviation(profile: ThicknessProfile, targets: WidthTargets) -> float:
    """Mean of measured over wanted width in the newest 20 mm of path; NaN = nothing measured."""
    if not len(profile):
        return np.nan
    newest = profile.arc_length >= profile.arc_length[-1] - WINDOW
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
        """Correct by the deviation of this capture."""
        del advice, now_ns
        ratio = deviation(profile, self._targets)
        if np.isfinite(ratio):
            self._scale = float(np.clip(self._scale / ratio**2, *LIMITS))

    def scale(self, now_ns: int) -> float:
        """The factor in force."""
        del now_ns
        return self._scale


class ProportionalIntegral:
    """A PI controller on the mean width, its integral held while it is limited.

    The gains are those with the least mean of the squared width error over the scenarios without a
    fault, relative to no feedback, on seeds of their own (``bpc_sim.studies.closedloop.tune``).
    """

    follows_advice = False

    def __init__(self, targets: WidthTargets, proportional: float = 0.6,
                 integral: float = 0.15) -> None:
        self._targets = targets
        self._proportional, self._rate = proportional, integral
        self._integral = 0.0
        self._scale = 1.0
        self._last_ns: int | None = None

    def take(self, profile: ThicknessProfile, advice: RateAdvice | None, now_ns: int) -> None:
        """Go on by one capture."""
        del advice, now_ns
        error = 1 - deviation(profile, self._targets)
        if not np.isfinite(error):
            return
        elapsed = 0.0 if self._last_ns is None else (profile.stamp_ns - self._last_ns) * 1e-9
        self._last_ns = profile.stamp_ns
        integral = self._integral + self._rate * error * elapsed
        wanted = 1 + self._proportional * error + integral
        self._scale = float(np.clip(wanted, *LIMITS))
        if self._scale == wanted:
            self._integral = integral

    def scale(self, now_ns: int) -> float:
        """The factor in force."""
        del now_ns
        return self._scale
