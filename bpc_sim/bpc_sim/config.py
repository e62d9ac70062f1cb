"""What the nodes of the synthetic printer agree on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from bpc_perception.core.config import Config, Parameter

from bpc_sim.print_job import PrintJob
from bpc_sim.scenarios import SCENARIOS, SPEED


@dataclass(frozen=True)
class SimConfig(Config):
    """The print that robot, extruder and camera re-enact, each from its own clock."""

    scenario: Annotated[str, Parameter(
        'What is printed', choices=tuple(SCENARIOS), read_only=True)] = 'spiral_gaps'
    speed: Annotated[float, Parameter(
        'Of the nozzle along the path', 'm/s', 1e-4, 0.5, read_only=True)] = SPEED
    start_time_ns: Annotated[int, Parameter(
        'When the job starts, the same for all nodes', 'ns', 0, 2**62, read_only=True)] = 0

    def job(self) -> PrintJob:
        """The print."""
        return SCENARIOS[self.scenario](self.speed)
