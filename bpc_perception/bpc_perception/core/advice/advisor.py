"""From measured thickness to rate advice: the command that makes the bead right.

The factors advised are on the command in force at the capture's stamp. Each width is held against
the flow and the speed that laid it. So what the controller has changed since counts as done
although it is not seen yet: the delay of measuring can neither make the loop unstable nor have a
deviation corrected twice.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from bpc_perception.core.advice.agreement import agreed
from bpc_perception.core.advice.contradictions import Contradictions
from bpc_perception.core.advice.correction import correct, Situation
from bpc_perception.core.advice.delivery_filter import Delivery
from bpc_perception.core.advice.laid import REACH
from bpc_perception.core.advice.observations import Finding, Observations
from bpc_perception.core.advice.planned import Planned
from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.advice.setup import Setup
from bpc_perception.core.advice.spreading import Spreading
from bpc_perception.core.advice.window import laid_before, look_back, Window
from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.targets import WidthTargets

LIFE_PERIODS = 2  # periods between captures that advice holds: one capture may be missed
GRACE_S = 0.5  # and so much longer, for its way from the capture to the controller
DELAY_S = 0.5  # from a capture until its advice has an effect
PERIODS_KEPT = 3  # between captures, the newest
# If the first capture comes later in a print, in lifetimes of advice, another advisor may have
# advised before.
LATE_LIVES = 3
LONGEST_LAG_S = 5.0  # that is looked ahead for


@dataclass
class _Command:
    """The command in force at a capture's stamp; NaN = not known yet.

    Attributes:
        volume: commanded per length of path.
        speed: of the nozzle [m/s].
        reference_time: before the stamp, over which both were averaged [s].
    """

    volume: float = np.nan
    speed: float = np.nan
    reference_time: float = np.nan


@dataclass
class _Print:
    """What is kept of the print that is advised on.

    Attributes:
        print_id: of the print.
        stamp_ns: of the capture before, or when the print started [ns].
        points: how many path points there were at the capture before.
        valid_until_ns: end of the newest advice's life [ns].
        late: whether another advisor may have advised before, and nothing was done about it yet.
        periods: newest times between captures [s].
        advised: whether there was advice before.
        correcting: whether the newest advice asked for a change.
        blind_until: arc length; what was laid before says nothing of the rate in force [m].
        prior: logarithm of the gain for which the print was set up; NaN = not known.
        observations: what captures and path say together; None before the first with a command.
        areas: the same of areas, instead of widths.
        command: in force.
        contradictions: among widths, as far as they are known.
        planned: the schedule in force; None = there is none.
        spreading: of ink after it was laid.
    """

    print_id: str
    stamp_ns: int
    points: int
    valid_until_ns: int
    late: bool
    periods: list[float] = field(default_factory=list)
    advised: bool = False
    correcting: bool = False
    blind_until: float = -np.inf
    prior: float = np.nan
    observations: Observations | None = None
    areas: Observations | None = None
    command: _Command = field(default_factory=_Command)
    contradictions: Contradictions = field(default_factory=Contradictions)
    planned: Planned | None = None
    spreading: Spreading = field(default_factory=Spreading)

    @classmethod
    def begun(cls, profile: ThicknessProfile, lifetime: float) -> _Print:
        """Begin with a print whose first capture gave this profile; advice lives so long [s]."""
        lifetime_ns = round(lifetime * 1e9)
        late = profile.stamp_ns - profile.print_start_ns > LATE_LIVES * lifetime_ns
        # Advice that may still be in force is no older than it lives.
        stamp_ns = profile.stamp_ns - lifetime_ns if late else profile.print_start_ns
        return cls(profile.print_id, stamp_ns, 0, profile.print_start_ns, late)

    def next_capture(self, stamp_ns: int, points: int) -> float:
        """Take note of a capture; return the time since the one before [s]."""
        elapsed = (stamp_ns - self.stamp_ns) * 1e-9
        self.periods = [*self.periods[1 - PERIODS_KEPT:], elapsed] if self.advised else []
        self.stamp_ns, self.points, self.advised = stamp_ns, points, True
        return elapsed

    @property
    def factors_ahead(self) -> tuple[float, float]:
        """Logarithms of the least and the largest factor that comes while advice holds."""
        least, largest = np.log(self.planned.ahead) if self.planned else (0.0, 0.0)
        return float(least), float(largest)

    @property
    def until_effect(self) -> float:
        """Time from the capture until the middle of what its advice is going to lay [s]."""
        return float(np.median(self.periods or [0.0]) / 2 + DELAY_S)

    def follow(self, planned: Planned | None) -> None:
        """Take a schedule; where another begins, what was learned before is not about it."""
        before, self.planned = self.planned, planned
        if (planned and planned.since) != (before and before.since):
            self.observations = self.areas = None

    def observe(self, path: DepositionPath, by_area: bool = False) -> Observations:
        """Return observations that begin, or those of a schedule that does."""
        if self.planned is None:
            return Observations(path, by_area=by_area)
        return Observations(path, self.planned.since, by_area, self.planned.sigma)

    def begin_anew(self, path: DepositionPath) -> bool:
        """Forget all observations if the rate is not recorded: nobody knows if it is changed now.

        Return whether that was so.
        """
        assert self.observations is not None
        if self.observations.rate_known:
            return False
        self.blind_until = path.arc_length[-1] + self.command.speed * self.until_effect
        self.observations = Observations(path, self.blind_until)
        self.areas = None  # without a recorded rate there is no volume to compare with
        return True


class Advisor:
    """Advises on one print after the other, from its captures in their order.

    It depends on nothing but profiles, paths and settings: live and offline runs agree.

    Args:
        targets: thickness wanted along the path; None = ``target_thickness`` everywhere.
        setup: of the prints before.

    Attributes:
        setup: of the newest print.
    """

    def __init__(self, targets: WidthTargets | None = None, setup: Setup | None = None) -> None:
        self._targets = targets
        self.setup = setup or Setup()
        self._print: _Print | None = None

    def advise(self, profile: ThicknessProfile, path: DepositionPath, config: AdviceConfig,
               contradiction: Reason | None = None,
               targets: WidthTargets | None = None,
               planned: Planned | None = None) -> RateAdvice:
        """Return advice after a capture.

        Args:
            profile: what was measured in it.
            path: of the print, up to the capture or further.
            config: limits and thresholds.
            contradiction: why profile and path do not fit to each other; None = they do.
            targets: thickness wanted along this print; None = as along all.
            planned: the schedule in force; None = there is none.
        """
        wanted = WidthTargets.wanted(targets or self._targets, config.target_thickness)
        if planned is None or wanted is None:
            return self._advise(profile, path, config, contradiction, wanted, None)
        advice = self._advise(
            planned.levelled(profile, wanted), planned.without(path), config, contradiction,
            WidthTargets.constant(float(wanted.at(planned.since))), planned)
        return planned.restored(advice, wanted)

    def _advise(self, profile: ThicknessProfile, path: DepositionPath, config: AdviceConfig,
                contradiction: Reason | None, wanted: WidthTargets | None,
                planned: Planned | None) -> RateAdvice:
        """Return advice, on top of what is planned."""
        covered = path.covers(profile.stamp_ns)
        path = path.until(profile.stamp_ns)
        current = self._print = self._print_of(profile, path, config.lifetime)
        current.follow(planned)
        seen = profile
        current.spreading.look(seen)
        profile = current.spreading.as_laid(laid_before(seen, config.acquisition_time))
        window = look_back(profile, config.window, current.blind_until)
        if contradiction is None and abs(window.offset) > config.maximum_offset:
            contradiction = Reason.PATH_OFFSET
        elapsed = current.next_capture(profile.stamp_ns, len(path))
        finding = self._find(current, path, profile, wanted, config)
        delivery = finding.models.estimate() if finding is not None else None
        target = _target_ahead(current, window, path, delivery, wanted)
        doubtful = current.contradictions.found(seen, window.extent)
        refusal = _refusal(current, window, path, None if doubtful else finding, covered,
                           np.isnan(target), contradiction, config)
        if current.late and finding is not None:
            current.late = False
            if current.begin_anew(path) and refusal is None:
                refusal = Reason.NOT_ENOUGH_DATA
        advice = _unchanged(current, profile, window, target, refusal, config.lifetime)
        if finding is None or delivery is None:
            return advice
        advice = _with_delivery(advice, current, delivery)
        if refusal is not None:
            current.correcting = False
            return advice
        assert current.observations is not None
        unrecorded = not current.observations.rate_known
        advice = _corrected(advice, current, finding, delivery, path, profile, elapsed,
                            self.setup.followed if unrecorded else 0.0, config)
        if unrecorded:
            self.setup = self.setup.after(float(np.log(advice.flow_rate_scale)))
        return advice

    def _print_of(self, profile: ThicknessProfile, path: DepositionPath,
                  lifetime: float) -> _Print:
        """Return what is kept of the print, or begin a new one."""
        known = self._print
        if (known is None or profile.print_id != known.print_id
                or profile.stamp_ns < known.stamp_ns or len(path) < known.points):
            return _Print.begun(profile, lifetime)
        return known

    def _find(self, current: _Print, path: DepositionPath, profile: ThicknessProfile,
              wanted: WidthTargets | None, config: AdviceConfig) -> Finding | None:
        """Find how much arrives, and the command in force; None without a target or a command."""
        if not path.extruding.any():
            return None
        observations = current.observations = current.observations or current.observe(path)
        observations.take(path, profile)
        if config.by_volume and (current.areas is not None or (profile.area > 0).any()):
            current.areas = current.areas or current.observe(path, by_area=True)
            current.areas.take(path, profile, observations)
        laid = observations.laid
        laying = np.flatnonzero(laid.laying)
        if len(laying) == 0:
            return None
        if wanted is not None and np.isnan(current.prior):
            # The print was set up so that what it begins with makes what is wanted there.
            start = path.arc_length[laying[0]]
            first = laying[path.arc_length[laying] <= start + config.window]
            gain = float(2 * np.log(wanted.at(start))
                         - np.log(np.median(laid.volume[first])))
            if not np.isnan(gain):
                self.setup = self.setup.of_print(gain, config)
                current.prior = self.setup.gain
        if np.isnan(current.prior):
            return None
        last = int(laying[-1])
        current.command = _Command(
            *observations.in_force(last),
            float((profile.stamp_ns - path.start_ns) * 1e-9 - path.time[max(last - REACH, 0)]))
        return observations.find(current.command.volume * current.command.speed, current.prior,
                                 config.clog_drop)


def _refusal(current: _Print, window: Window, path: DepositionPath, finding: Finding | None,
             covered: bool, aimless: bool, contradiction: Reason | None,
             config: AdviceConfig) -> Reason | None:
    """Return why nothing is to be changed; None = nothing speaks against it."""
    stalled = current.observations is not None and current.observations.stalled(path)
    lost = current.observations is not None and not current.observations.speed_known(path)
    too_little = (window.count < config.minimum_samples
                  or window.coverage < config.minimum_coverage or finding is None)
    fallen = finding is not None and finding.fallen >= config.gap_length
    # The first condition that holds counts.
    conditions = (
        (aimless, Reason.NO_TARGET),
        (stalled, Reason.EXTRUDER_FAULT),
        (not covered or lost, Reason.STALE_DATA),
        (contradiction is not None, contradiction),
        (window.longest_gap >= config.gap_length, Reason.GAP_DETECTED),
        (too_little, Reason.NOT_ENOUGH_DATA),
        (window.age > config.stale_after, Reason.STALE_DATA),
        (fallen, Reason.CLOG_SUSPECTED))
    return next((reason for holds, reason in conditions if holds), None)


def _target_ahead(current: _Print, window: Window, path: DepositionPath,
                  delivery: Delivery | None, wanted: WidthTargets | None) -> float:
    """Return the thickness wanted where the advice is going to take effect [m]; NaN = none."""
    if wanted is None:
        return np.nan
    if delivery is None:
        return float(wanted.at(window.extent[1]))
    ahead = current.until_effect + min(delivery.lag, LONGEST_LAG_S)
    return float(wanted.at(path.arc_length[-1] + current.command.speed * ahead))


def _unchanged(current: _Print, profile: ThicknessProfile, window: Window, target: float,
               refusal: Reason | None, lifetime: float) -> RateAdvice:
    """Return advice that changes nothing, and prolong its life unless the data is no good."""
    if refusal not in (Reason.STALE_DATA, Reason.NO_TARGET):
        life = min(lifetime, LIFE_PERIODS * max(current.periods, default=np.inf) + GRACE_S)
        current.valid_until_ns = profile.stamp_ns + round(1e9 * life)
    return RateAdvice(
        stamp_ns=profile.stamp_ns, print_id=profile.print_id, valid=refusal is None,
        reason=Reason.ON_TARGET if refusal is None else refusal, target_thickness=target,
        measured_thickness=window.width, window=window.extent, sample_count=window.count,
        flow_rate_scale=1.0, speed_scale=1.0, confidence=0.0, measurement_age=window.age,
        valid_until_ns=current.valid_until_ns, spreading=current.spreading.rate)


def _with_delivery(advice: RateAdvice, current: _Print, delivery: Delivery) -> RateAdvice:
    """Return advice that says what is known of the delivery."""
    command = current.command
    return replace(
        advice, reference_time=command.reference_time,
        expected_thickness=float(np.exp((delivery.gain + np.log(command.volume)) / 2)),
        delivery=float(np.exp(delivery.gain - current.prior)),
        delivery_sigma=delivery.gain_sigma, lag=delivery.lag, lag_sigma=delivery.lag_sigma)


def _corrected(advice: RateAdvice, current: _Print, finding: Finding, delivery: Delivery,
               path: DepositionPath, profile: ThicknessProfile, elapsed: float, followed: float,
               config: AdviceConfig) -> RateAdvice:
    """Return valid advice: the factors that reach the target, as far as they are allowed."""
    assert current.observations is not None
    # Of the recent past: a corner now says nothing of what is to come.
    speed, rate = np.log(current.observations.means(config.window))
    situation = Situation(
        area=2 * np.log(advice.target_thickness), speed=speed, rate=rate,
        volume=np.log(current.command.volume),
        lacking=2 * np.log(advice.target_thickness / advice.measured_thickness),
        prior=current.prior, correcting=current.correcting, followed=followed, elapsed=elapsed,
        longest_period=max(current.periods, default=0.0), until_effect=current.until_effect,
        planned=current.factors_ahead)
    correction = correct(situation, finding, delivery, config)
    area = measured_area(profile, advice.window)
    by_area = (config.by_volume and current.areas is not None and area > 0
               and current.areas.is_volume())
    if by_area:
        assert current.areas is not None
        seen = current.areas.find(current.command.volume * current.command.speed, current.prior,
                                  config.clog_drop)
        lacking = situation.area - np.log(area) - current.prior
        correction = agreed(correction, correct(replace(situation, lacking=lacking), seen,
                                                seen.models.estimate(), config),
                            current.spreading.noticed)
    current.correcting = correction.reason not in (Reason.ON_TARGET, Reason.VOLUME_DISAGREES)
    if current.correcting:
        current.begin_anew(path)
    flow_scale, speed_scale = correction.flow_scale, correction.speed_scale
    last = int(np.flatnonzero(path.extruding)[-1])
    # Where a schedule changes the flow all the time, no value of it holds.
    held = np.nan if current.planned else flow_scale
    return replace(
        advice, reason=correction.reason, confidence=correction.confidence,
        flow_rate_scale=flow_scale, speed_scale=speed_scale,
        flow_rate=float(path.flow_rate[last]) * held,
        plunger_velocity=float(path.plunger_velocity[last]) * held,
        speed=float(current.command.speed) * speed_scale,
        by_volume=by_area, measured_area=area)


def measured_area(profile: ThicknessProfile, extent: tuple[float, float]) -> float:
    """Return the median area between two arc lengths [m^2]; NaN = not known."""
    inside = (profile.arc_length >= extent[0]) & (profile.arc_length <= extent[1])
    area = profile.area[inside & (profile.area > 0)]
    return float(np.median(area)) if len(area) else np.nan
