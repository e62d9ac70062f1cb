"""The path of a print: where and when the nozzle passed, and what the extruder did."""

from __future__ import annotations

from dataclasses import dataclass, replace

from bpc_perception.core.arrays import Array, Flags


@dataclass(frozen=True)
class DepositionPath:
    """N path points, evenly spaced by arc length.

    Attributes:
        print_id: identifier of the print; empty = none.
        start_ns: zero of ``time`` [ns].
        complete_until: every point up to this time is there [s after start_ns].
        finished: whether the print was stopped.
        time: (N,) when the nozzle passed [s after start_ns], strictly increasing.
        arc_length: (N,) [m].
        points: (N, 3) nozzle tip in the robot base frame [m].
        plunger_velocity: (N,) [m/s]; NaN = unknown.
        flow_rate: (N,) [m^3/s]; NaN = unknown.
        extruding: (N,) whether ink was being pushed out; False where unknown.
        extruder_known: (N,) whether the extruder's state is known.
    """

    print_id: str
    start_ns: int
    complete_until: float
    finished: bool
    time: Array
    arc_length: Array
    points: Array
    plunger_velocity: Array
    flow_rate: Array
    extruding: Flags
    extruder_known: Flags

    def __len__(self) -> int:
        return len(self.time)

    def covers(self, stamp_ns: int) -> bool:
        """Return whether every point that the nozzle passed up to this time [ns] is known."""
        return self.finished or self.complete_until >= (stamp_ns - self.start_ns) * 1e-9

    def until(self, stamp_ns: int) -> DepositionPath:
        """Return the part that the nozzle had passed at this time [ns]."""
        return self.where(self.time <= (stamp_ns - self.start_ns) * 1e-9)

    def moved_to(self, points: Array) -> DepositionPath:
        """Return the path with its points elsewhere (N, 3)."""
        return replace(self, points=points)

    def where(self, kept: Flags) -> DepositionPath:
        """Return the path without the points at which ``kept`` (N,) is False."""
        return replace(
            self, time=self.time[kept], arc_length=self.arc_length[kept],
            points=self.points[kept], plunger_velocity=self.plunger_velocity[kept],
            flow_rate=self.flow_rate[kept], extruding=self.extruding[kept],
            extruder_known=self.extruder_known[kept])
