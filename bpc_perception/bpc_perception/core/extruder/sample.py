"""The extruder's state, as the path needs it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ExtruderSample:
    """What the extruder did at one time.

    Attributes:
        stamp_ns: when [ns].
        extruding: whether ink was being pushed out; False if unknown.
        plunger_velocity: [m/s]; NaN = unknown.
        flow_rate: [m^3/s]; NaN = unknown.
    """

    stamp_ns: int
    extruding: bool
    plunger_velocity: float
    flow_rate: float
