"""The extruder's state as the path carries it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ExtruderSample:
    """What the extruder did at one time [ns]; velocity [m/s] and flow [m^3/s], NaN = unknown."""

    stamp_ns: int
    extruding: bool
    plunger_velocity: float
    flow_rate: float
