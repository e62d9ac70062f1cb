"""From measured thickness to rate advice: what the command has to be for the bead to be right.

The factors advised are on the command in force at the capture's stamp. Each width is held against
the flow and the speed that laid it, so what the controller has changed since counts as
done although it is not seen yet: the delay of measuring can neither make the loop
unstable nor have a deviation corrected twice.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.advice.delivery_filter import Delivery, PRIOR_SIGMA
from bpc_perception.core.advice.observations import Finding, PrintRecord, REACH
from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import run_extents, Status, ThicknessProfile

LIFE_PERIODS = 2  # periods between captures that advice holds: one capture may be missed
GRACE = 0.5  # and so much longer, for its way from the capture to the controller [s]
DELAY = 0.5  # from a capture until its advice has an effect [s]
# Whose first capture comes later in a print, in lifetimes of advice, may have had a predecessor.
LATE_LIVES = 3
LONGEST_LAG = 5.0  # looked ahead for [s]
# In which a flow behind a long lag is to be right: so many seconds, or periods between captures.
HORIZON, HORIZON_PERIODS = 3.0, 1.0


@dataclass(frozen=True)
class _Window:
    """The newest stretch on which ink was to be laid, and what is measured there."""

    extent: tuple[float, float]
    count: int
    coverage: float
    width: float
    offset: float
    age: float
    longest_gap: float


class Advisor:
    """Advises on one print after the other, from its captures in their order.

    It depends on nothing but profiles, paths and settings: live and offline runs agree.

    Args:
        targets: thickness wanted along the path; None = ``target_thickness`` everywhere.
    """

    _record: PrintRecord | None
    _periods: list[float]
    _advised: bool
    _late: bool
    _blind_until: float

    def __init__(self, targets: WidthTargets | None = None) -> None:
        self._targets = targets
        self._print_id: str | None = None
        self._stamp_ns = self._points = 0

    def advise(self, profile: ThicknessProfile, path: DepositionPath,
               config: AdviceConfig) -> RateAdvice:
        """Advice after a capture.

        Args:
            profile: what was measured in it.
            path: of the print, up to the capture or further.
            config: limits and thresholds.
        """
        covered = path.covers(profile.stamp_ns)
        path = path.until(profile.stamp_ns)
        again = profile.stamp_ns < self._stamp_ns or len(path) < self._points
        if profile.print_id != self._print_id or again:
            self._begin(profile, config.lifetime)
        self._points = len(path)
        profile = _laid_before(profile, config.acquisition_time)
        window = _look(profile, config.window, self._blind_until)
        elapsed = (profile.stamp_ns - self._stamp_ns) * 1e-9
        self._periods = [*self._periods[-2:], elapsed] if self._advised else []
        self._stamp_ns, self._advised = profile.stamp_ns, True
        finding = self._find(path, profile, config) if path.extruding.any() else None
        delivery = finding.models.estimate() if finding is not None else None
        target = self._target(window.extent[1] if delivery is None else path.arc_length[-1]
                              + self._speed * (self._until_effect
                                               + min(delivery.lag, LONGEST_LAG)), config)
        refusal = self._refusal(window, path, finding, covered, np.isnan(target), config)
        if self._late and finding is not None:
            self._late = False
            if self._forget(path) and refusal is None:
                refusal = Reason.NOT_ENOUGH_DATA
        if refusal not in (Reason.STALE_DATA, Reason.NO_TARGET):
            self._valid_until_ns = profile.stamp_ns + round(1e9 * min(
                config.lifetime, LIFE_PERIODS * max(self._periods, default=np.inf) + GRACE))
        advice = RateAdvice(
            stamp_ns=profile.stamp_ns, print_id=profile.print_id, valid=refusal is None,
            reason=Reason.ON_TARGET if refusal is None else refusal, target_thickness=target,
            measured_thickness=window.width, window=window.extent, sample_count=window.count,
            flow_rate_scale=1.0, speed_scale=1.0, confidence=0.0, measurement_age=window.age,
            valid_until_ns=self._valid_until_ns)
        if finding is None or delivery is None:
            return advice
        advice = replace(
            advice, reference_time=self._reference_time,
            expected_thickness=float(np.exp((delivery.gain + np.log(self._commanded)) / 2)),
            delivery=float(np.exp(delivery.gain - self._prior)),
            delivery_sigma=delivery.gain_sigma, lag=delivery.lag, lag_sigma=delivery.lag_sigma)
        if refusal is not None:
            self._correcting = False
            return advice
        return self._correct(advice, finding, delivery, path, elapsed, config)

    def _begin(self, profile: ThicknessProfile, lifetime: float) -> None:
        self._print_id = profile.print_id
        self._record = None
        self._prior = np.nan
        # In force at the stamp: volume per length, and speed [m/s].
        self._commanded = self._speed = self._reference_time = np.nan
        self._periods = []
        self._stamp_ns = self._valid_until_ns = profile.print_start_ns
        lifetime_ns = round(lifetime * 1e9)
        self._late = profile.stamp_ns - self._stamp_ns > LATE_LIVES * lifetime_ns
        if self._late:  # advice that may still be in force is no older than it lives
            self._stamp_ns = profile.stamp_ns - lifetime_ns
        self._advised = self._correcting = False
        self._blind_until = -np.inf  # what was laid before says nothing of the rate in force [m]

    def _target(self, arc_length: float, config: AdviceConfig) -> float:
        if self._targets is not None:
            return float(self._targets.at(arc_length))
        return config.target_thickness or np.nan

    def _find(self, path: DepositionPath, profile: ThicknessProfile,
              config: AdviceConfig) -> Finding | None:
        """How much arrives, and the command in force; None without a target or a command."""
        record = self._record = self._record or PrintRecord(path)
        record.take(path, profile)
        laying = np.flatnonzero(record.laying)
        if len(laying) == 0:
            return None
        if np.isnan(self._prior):
            # The print was set up so that what it begins with makes what is wanted there.
            target = self._target(path.arc_length[laying[0]], config)
            first = laying[path.arc_length[laying] <= path.arc_length[laying[0]] + config.window]
            self._prior = float(2 * np.log(target) - np.log(np.median(record.commanded[first])))
        if np.isnan(self._prior):
            return None
        last = int(laying[-1])
        self._commanded, self._speed = record.commanded[last], record.speed[last]
        self._reference_time = float((profile.stamp_ns - path.start_ns) * 1e-9
                                     - path.time[max(last - REACH, 0)])
        return record.find(self._commanded * self._speed, self._prior, config.clog_drop)

    @property
    def _until_effect(self) -> float:
        """Time from the capture until the middle of what this advice is going to lay [s]."""
        return float(np.median(self._periods or [0.0]) / 2 + DELAY)

    def _refusal(self, window: _Window, path: DepositionPath, finding: Finding | None,
                 covered: bool, aimless: bool, config: AdviceConfig) -> Reason | None:
        """Why nothing is to be changed; None = nothing speaks against it."""
        if aimless:
            return Reason.NO_TARGET
        if self._record is not None and self._record.stalled(path):
            return Reason.EXTRUDER_FAULT
        if not covered:
            return Reason.STALE_DATA
        if window.longest_gap >= config.gap_length:
            return Reason.GAP_DETECTED
        if abs(window.offset) > config.maximum_offset:
            return Reason.PATH_OFFSET
        if (window.count < config.minimum_samples or window.coverage < config.minimum_coverage
                or finding is None):
            return Reason.NOT_ENOUGH_DATA
        if window.age > config.stale_after:
            return Reason.STALE_DATA
        if finding.fallen >= config.gap_length:
            return Reason.CLOG_SUSPECTED
        return None

    def _correct(self, advice: RateAdvice, finding: Finding, delivery: Delivery,
                 path: DepositionPath, elapsed: float, config: AdviceConfig) -> RateAdvice:
        """Valid advice: the factors that reach the target, as far as they are allowed."""
        assert self._record is not None
        area, present = 2 * np.log(advice.target_thickness), np.log(self._commanded)
        # Of the recent past, lest a corner be taken for what is to come.
        speed, command = np.log(self._record.means(config.window))
        horizon = max(HORIZON, HORIZON_PERIODS * max(self._periods, default=0.0))
        # Volume per length that reaches the target: by the flow at this speed, and by the speed
        # at this flow, which a lag does not delay. Both stay in proportion to what the print was
        # set up with, however often advice is followed.
        wanted = np.array((
            finding.models.rate_for(area + speed, finding.flow, horizon) - speed,
            area + command - finding.models.after(
                float(np.exp(command)), finding.flow, self._until_effect)))
        least, most = np.log((config.minimum_scale, config.maximum_scale))
        nominal = area - self._prior
        believed = np.clip(wanted, nominal + least, nominal + most)
        confidence = 1 / (1 + (delivery.gain_sigma / PRIOR_SIGMA)**2)
        advice = replace(advice, confidence=confidence)
        band = 2 * np.log1p(config.dead_band) / (3 if self._correcting else 1)
        self._correcting = bool(np.abs(wanted - present).max() > band)
        changes = np.zeros(2)
        if self._correcting:
            step = config.slew_rate * elapsed
            asked = confidence * (believed - present) * (1, -1)  # the speed goes against the flow
            changes = np.clip(asked, max(least, -step), min(most, step))
            if (changes != asked).any() or (believed != wanted).any():
                reason = Reason.LIMITED
            else:
                reason = (Reason.UNDER_EXTRUSION if wanted[0] > present
                          else Reason.OVER_EXTRUSION)
            advice = replace(advice, reason=reason)
            self._forget(path)
        flow_scale, speed_scale = np.exp(changes).tolist()
        last = int(np.flatnonzero(path.extruding)[-1])
        return replace(
            advice, flow_rate_scale=flow_scale, speed_scale=speed_scale,
            flow_rate=float(path.flow_rate[last]) * flow_scale,
            plunger_velocity=float(path.plunger_velocity[last]) * flow_scale,
            speed=float(self._speed) * speed_scale)

    def _forget(self, path: DepositionPath) -> bool:
        """Begin anew where the rate is not recorded: whether it is changed now nobody knows."""
        assert self._record is not None
        if self._record.rate_known:
            return False
        self._blind_until = path.arc_length[-1] + self._speed * self._until_effect
        self._record = PrintRecord(path, self._blind_until)
        return True


def _laid_before(profile: ThicknessProfile, acquisition_time: float) -> ThicknessProfile:
    """The profile without what was laid while the camera looked: not yet there is no gap."""
    began = (profile.stamp_ns - profile.print_start_ns) * 1e-9 - acquisition_time
    return replace(profile, status=np.where(
        profile.time > began, Status.NO_DATA, profile.status).astype(np.uint8))


def _look(profile: ThicknessProfile, length: float, start: float) -> _Window:
    """The newest stretch of path of this length, after ``start``, where ink was to be laid."""
    extruding = profile.extruding & (profile.arc_length >= start)
    ends = profile.arc_length[extruding]
    extent = (float(max(ends[-1] - length, profile.arc_length[0], start)),
              float(ends[-1])) if len(ends) else (np.nan, np.nan)
    inside = ((profile.arc_length >= extent[0]) & (profile.arc_length <= extent[1])
              & extruding)
    measured = inside & (profile.status == Status.MEASURED)
    count = int(measured.sum())
    gaps = run_extents(inside & (profile.status == Status.GAP), profile.arc_length)
    longest_gap = float(np.diff(gaps).max(initial=0))
    if not count:
        return _Window(extent, 0, 0.0, np.nan, np.nan, np.nan, longest_gap)
    age = (profile.stamp_ns - profile.print_start_ns) * 1e-9 - float(profile.time[measured][-1])
    return _Window(
        extent, count, count / int(inside.sum()), float(np.median(profile.thickness[measured])),
        float(np.median(profile.left[measured] - profile.right[measured])) / 2, age, longest_gap)
