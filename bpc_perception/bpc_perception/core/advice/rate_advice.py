"""What is advised to the print controller after a capture."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np


class Reason(IntEnum):
    """Why the advice is as it is; the numbers are those of RateAdvice.msg."""

    ON_TARGET = 0
    UNDER_EXTRUSION = 1
    OVER_EXTRUSION = 2
    LIMITED = 3
    NOT_ENOUGH_DATA = 4
    GAP_DETECTED = 5
    STALE_DATA = 6
    NO_TARGET = 7
    CLOG_SUSPECTED = 8
    PATH_OFFSET = 9
    EXTRUDER_FAULT = 10
    VOLUME_DISAGREES = 11


@dataclass(frozen=True)
class RateAdvice:
    """By how much to change the flow rate, or else the speed; see RateAdvice.msg.

    Attributes:
        stamp_ns: stamp of the capture [ns].
        print_id: identifier of the print.
        valid: whether the scales may be applied.
        reason: why it is as it is.
        target_thickness, measured_thickness: [m]; NaN = none.
        window: arc lengths from and to [m]; NaN = none.
        sample_count: MEASURED samples in the window.
        flow_rate_scale, speed_scale: factors on what was in force at the stamp; each of them
            alone reaches the target; 1 if not valid.
        reference_time: time before the stamp, over which what was in force was averaged [s].
        confidence: 0 to 1.
        measurement_age: time from laying the newest MEASURED sample to the capture [s].
        valid_until_ns: end of the advice's life [ns].
        expected_thickness: thickness that the command in force at the stamp makes [m]; NaN =
            unknown.
        delivery: how much arrives, as a share of what the print was set up for; NaN = unknown.
        delivery_sigma: relative standard deviation of ``delivery``; NaN = unknown.
        lag, lag_sigma: time constant of the delivery and its standard deviation [s].
        flow_rate, plunger_velocity, speed: the advice as values [m^3/s, m/s, m/s]; NaN =
            unknown.
        by_volume: whether width and volume had to agree on it; else it is by width alone.
        measured_area: median area of the cross-section in the window [m^2]; NaN = unknown.
        spreading: by how much ink widens after it was laid, as a share of its width [1/s]; 0 = as
            far as is known it does not, NaN = unknown.
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
    reference_time: float = 0.0
    expected_thickness: float = np.nan
    delivery: float = np.nan
    delivery_sigma: float = np.nan
    lag: float = np.nan
    lag_sigma: float = np.nan
    flow_rate: float = np.nan
    plunger_velocity: float = np.nan
    speed: float = np.nan
    by_volume: bool = False
    measured_area: float = np.nan
    spreading: float = np.nan

    @classmethod
    def none(cls, stamp_ns: int) -> RateAdvice:
        """Return that from this time on [ns] there is no print to advise on."""
        nan = float('nan')
        return cls(stamp_ns, '', valid=False, reason=Reason.NOT_ENOUGH_DATA, target_thickness=nan,
                   measured_thickness=nan, window=(nan, nan), sample_count=0,
                   flow_rate_scale=1.0, speed_scale=1.0, confidence=0.0, measurement_age=nan,
                   valid_until_ns=stamp_ns)

    @property
    def flow_rate_in_force(self) -> float:
        """The flow rate commanded at the stamp, on which the factor is [m^3/s]; NaN = unknown."""
        return self.flow_rate / self.flow_rate_scale

    @property
    def speed_in_force(self) -> float:
        """The speed of the nozzle then [m/s]; NaN = unknown."""
        return self.speed / self.speed_scale
