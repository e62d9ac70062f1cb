"""Parameters that the nodes of the synthetic printer share."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

from bpc_perception.core.parameter import Config, Parameter
from bpc_sim.closed_loop.job import ClosedLoopJob
from bpc_sim.closed_loop.situations import SITUATIONS
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import (
    camera_view,
    POSE_RATE_HZ,
    PRINT_SPEED_M_PER_S,
    SCENARIOS,
)
from bpc_sim.scene.camera import M70_HEIGHT_PX, M70_WIDTH_PX


@dataclass(frozen=True)
class SimConfig(Config):
    """The print that robot, extruder and camera simulate, each from its own clock."""

    scenario: Annotated[str, Parameter(
        'What is printed', choices=tuple(SCENARIOS), read_only=True)] = 'spiral_gaps'
    speed: Annotated[float, Parameter(
        'Of the nozzle along the path', 'm/s', 1e-4, 0.5, read_only=True)] = PRINT_SPEED_M_PER_S
    situation: Annotated[str, Parameter(
        'In a closed loop: what goes wrong, on a meander; empty = open loop',
        choices=('', *SITUATIONS), read_only=True)] = ''
    seed: Annotated[int, Parameter(
        'In a closed loop: which printer', '', 0, 2**31, read_only=True)] = 0
    start_time_ns: Annotated[int, Parameter(
        'When the job starts, the same for all nodes', 'ns', 0, 2**62, read_only=True)] = 0

    pose_rate: Annotated[float, Parameter(
        'Poses that the robot sends', 'Hz', 1, 1000, read_only=True)] = POSE_RATE_HZ
    full_size: Annotated[bool, Parameter(
        'Captures of 1944 x 1200 pixels instead of their middle', read_only=True)] = False
    finished: Annotated[bool, Parameter(
        'Captures show the finished print, rendered once: for timing', read_only=True)] = False

    def job(self) -> PrintJob:
        """Return the print."""
        job = SCENARIOS[self.scenario](self.speed)
        if self.full_size:
            return replace(job, view=camera_view(M70_WIDTH_PX, M70_HEIGHT_PX))
        return job

    def closed_loop_job(self) -> ClosedLoopJob:
        """Return the faulty print. Raises ValueError where no situation is named."""
        return ClosedLoopJob.named(self.situation, self.seed, self.speed)


@dataclass(frozen=True)
class ControllerConfig(Config):
    """Parameters of the print controller."""

    actuator: Annotated[str, Parameter(
        'What it corrects', choices=('flow', 'speed'), read_only=True)] = 'flow'
