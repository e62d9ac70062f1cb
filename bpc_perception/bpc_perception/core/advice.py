"""From measured thickness to rate advice, by conservation of volume."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.profile import run_extents, Status, ThicknessProfile


class Reason(IntEnum):
    """Why the advice is what it is; the numbers are those of RateAdvice.msg."""

    ON_TARGET = 0
    UNDER_EXTRUSION = 1
    OVER_EXTRUSION = 2
    LIMITED = 3
    NOT_ENOUGH_DATA = 4
    GAP_DETECTED = 5
    STALE_DATA = 6
    NO_TARGET = 7


@dataclass(frozen=True)
class RateAdvice:
    """By how much to change the flow rate, or else the speed; see RateAdvice.msg.

    Attributes:
        stamp_ns: stamp of the capture [ns].
        print_id: identifier of the print.
        valid: whether the scales may be applied.
        reason: why.
        target_thickness, measured_thickness: [m]; NaN = none.
        window: arc lengths from and to [m]; NaN = none.
        sample_count: MEASURED samples in the window.
        flow_rate_scale, speed_scale: factors, each alone reaching the target; 1 if not valid.
        confidence: 0 to 1.
        measurement_age: from the laying of the newest MEASURED sample to the capture [s].
        valid_until_ns: end of the advice's life [ns].
    """

    stamp_ns: int
    print_id: str
    valid: bool
    reason: Reason
    target_thickness: float
    measured_thickness: float
    window: tuple[float, float]
    sample_count: int
    flow_rate_scale: float
    speed_scale: float
    confidence: float
    measurement_age: float
    valid_until_ns: int


def advise(profile: ThicknessProfile, config: AdviceConfig) -> RateAdvice:
    """Advice from the newest stretch of path on which ink was to be laid.

    A round bead of width w laid at speed v takes the flow Q = (pi / 4) w^2 v, so the flow has
    to change by (target / measured)^2, or the speed by its inverse. The width is the median
    over the window: it stays right while less than half of the samples are wrong.
    """
    ends = profile.arc_length[profile.extruding]
    window = (float(max(ends[-1] - config.window, profile.arc_length[0])),
              float(ends[-1])) if len(ends) else (np.nan, np.nan)
    inside = ((profile.arc_length >= window[0]) & (profile.arc_length <= window[1])
              & profile.extruding)
    measured = inside & (profile.status == Status.MEASURED)
    count = int(measured.sum())
    width = float(np.median(profile.thickness[measured])) if count else np.nan
    coverage = count / inside.sum() if count else 0.0
    capture_time = (profile.stamp_ns - profile.print_start_ns) * 1e-9
    age = capture_time - float(profile.time[measured][-1]) if count else np.nan
    gaps = run_extents(inside & (profile.status == Status.GAP), profile.arc_length)

    wanted = (config.target_thickness / width) ** 2 if count else np.nan
    scale = float(np.clip(wanted, config.minimum_scale, config.maximum_scale))
    if config.target_thickness == 0:
        reason = Reason.NO_TARGET
    elif (np.diff(gaps) >= config.gap_length).any():
        reason = Reason.GAP_DETECTED
    elif count < config.minimum_samples or coverage < config.minimum_coverage:
        reason = Reason.NOT_ENOUGH_DATA
    elif age > config.stale_after:
        reason = Reason.STALE_DATA
    elif abs(width / config.target_thickness - 1) <= config.dead_band:
        reason, scale = Reason.ON_TARGET, 1.0
    elif scale != wanted:
        reason = Reason.LIMITED
    else:
        reason = Reason.UNDER_EXTRUSION if wanted > 1 else Reason.OVER_EXTRUSION
    valid = reason in (Reason.ON_TARGET, Reason.UNDER_EXTRUSION, Reason.OVER_EXTRUSION,
                       Reason.LIMITED)
    return RateAdvice(
        stamp_ns=profile.stamp_ns, print_id=profile.print_id, valid=valid, reason=reason,
        target_thickness=config.target_thickness or np.nan, measured_thickness=width,
        window=window, sample_count=count,
        flow_rate_scale=scale if valid else 1.0,
        speed_scale=float(np.clip(1 / scale, config.minimum_scale, config.maximum_scale))
        if valid else 1.0,
        confidence=_confidence(profile, measured, coverage) if valid else 0.0,
        measurement_age=age,
        valid_until_ns=profile.stamp_ns + round(config.lifetime * 1e9))


def _confidence(profile: ThicknessProfile, measured: np.ndarray, coverage: float) -> float:
    """Share of the window measured, less the relative spread of what was measured there."""
    widths = profile.thickness[measured]
    return float(coverage * max(0.0, 1.0 - widths.std() / widths.mean()))
