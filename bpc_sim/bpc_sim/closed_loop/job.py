"""A print that goes wrong, on the bed and before the camera of the other scenarios."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import invert, transform
from bpc_sim.closed_loop.loop import Situation, SPEED
from bpc_sim.closed_loop.situations import situation
from bpc_sim.ink.deposit import Deposit
from bpc_sim.ink.extrusion import Extrusion, THINNEST
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import meander

BORDERS = 1e-4  # to which the ends of gaps are found [m]


@dataclass(frozen=True, eq=False)
class ClosedLoopJob:
    """The robot's program, and what goes wrong when it is carried out.

    Attributes:
        job: path, bed and camera; its own time runs faster or slower than that of the clock,
            with the speed of the robot.
        situation: what goes wrong.
    """

    job: PrintJob
    situation: Situation

    @classmethod
    def named(cls, name: str, seed: int, speed: float = SPEED) -> ClosedLoopJob:
        """A meander that goes wrong in the way of this name, at this nominal speed [m/s]."""
        job = meander(speed)
        usual = situation(name, seed, job.length)
        return cls(job, replace(usual, speed=lambda s: usual.speed(s) * (speed / SPEED)))

    def speed(self, s: float) -> float:
        """Nominal speed at an arc length [m/s]."""
        return float(self.situation.speed(np.array(s)))

    def flow(self, s: float) -> float:
        """Nominal flow at an arc length [m^3/s]."""
        return self.situation.behaviour.flow_for(self.situation.width, self.speed(s))

    def deposit(self, extrusion: Extrusion, laid: float) -> Deposit:
        """The ink laid up to an arc length [m]."""
        curve = self.job.commanded.curve
        s = np.arange(0.0, curve.length + BORDERS, BORDERS)
        bare = np.concatenate(([False], extrusion.width(s) == 0, [False])).astype(np.int8)
        starts, ends = np.flatnonzero(np.diff(bare) == 1), np.flatnonzero(np.diff(bare) == -1) - 1
        # Half a step to either side; a print that has not begun is one gap.
        gaps = np.column_stack((s[starts] - BORDERS / 2, s[ends] + BORDERS / 2))

        def profile(s: Array) -> Array:
            s = np.asarray(s)
            return np.maximum(extrusion.width(s.ravel()).reshape(s.shape), THINNEST)

        return replace(self.job.commanded, profile=profile, gaps=gaps, laid=laid,
                       height_ratio=self.situation.behaviour.height_ratio)

    def nearest(self, tip: Array) -> float:
        """Arc length of the point of the path nearest to a tip (3,) in the base frame [m]."""
        curve = self.job.commanded.curve
        s = curve.uniform(round(curve.length / BORDERS) + 1)
        planar = transform(invert(self.job.T_base_surface), tip)[:2]
        return float(s[np.argmin(np.linalg.norm(curve.points(s) - planar, axis=1))])

    def tip(self, T_base_flange: Array) -> Array:
        """Nozzle tip (3,) in the base frame [m]."""
        return transform(T_base_flange, np.asarray(self.job.nozzle_offset))
