"""A print that goes wrong, on the bed and in front of the camera of the other scenarios."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import invert, transform
from bpc_sim.closed_loop.situation import NOMINAL_SPEED_M_PER_S, Situation
from bpc_sim.closed_loop.situations import make_situation
from bpc_sim.ink.deposit import Deposit
from bpc_sim.ink.extrusion import Extrusion
from bpc_sim.ink.laid_bead import laid_bead
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import meander

ARC_STEP_M = 1e-4  # between the arc lengths at which gaps and the nozzle are looked for


@dataclass(frozen=True, eq=False)
class ClosedLoopJob:
    """The robot's program, and what goes wrong when the robot carries it out.

    Attributes:
        job: path, bed and camera; its time runs faster or slower than the clock, with the speed
            of the robot.
        situation: what goes wrong.
    """

    job: PrintJob
    situation: Situation

    @classmethod
    def named(cls, name: str, seed: int, speed: float = NOMINAL_SPEED_M_PER_S) -> ClosedLoopJob:
        """Return a meander in the situation of a name, at a nominal speed [m/s].

        Raises:
            ValueError: there is no situation of that name.
        """
        job = meander(speed)
        usual = make_situation(name, seed, job.length)
        return cls(job, replace(usual, speed=lambda s: (
            usual.speed(s) * (speed / NOMINAL_SPEED_M_PER_S))))

    @property
    def duration(self) -> float:
        """Time from the job's start to its end by the clock, unless the speed is corrected [s]."""
        steps = self.job.commanded.curve.uniform(round(self.job.length / ARC_STEP_M) + 1)
        pace = 1 / self.situation.speed((steps[1:] + steps[:-1]) / 2)
        moving = float(np.sum(np.diff(steps) * pace))
        return self.job.dwell_before + moving + self.job.dwell_after

    def speed(self, s: float) -> float:
        """Return the nominal speed [m/s] at an arc length [m]."""
        return float(self.situation.speed(np.array(s)))

    def flow(self, s: float) -> float:
        """Return the nominal flow [m^3/s] at an arc length [m]."""
        return self.situation.behaviour.flow_for(self.situation.width, self.speed(s))

    def deposit(self, extrusion: Extrusion, laid: float) -> Deposit:
        """Return the ink laid up to an arc length [m]."""
        return replace(laid_bead(self.job.commanded, extrusion, ARC_STEP_M), laid=laid)

    def nearest(self, tip: Array) -> float:
        """Return the arc length [m] of the path's point nearest to a tip (3,) [m] of the base."""
        curve = self.job.commanded.curve
        s = curve.uniform(round(curve.length / ARC_STEP_M) + 1)
        planar = transform(invert(self.job.T_base_surface), tip)[:2]
        return float(s[np.argmin(np.linalg.norm(curve.points(s) - planar, axis=1))])

    def tip(self, T_base_flange: Array) -> Array:
        """Return the nozzle tip (3,) in the base frame [m] for a pose (4, 4) of the flange."""
        return transform(T_base_flange, np.asarray(self.job.nozzle_offset))
