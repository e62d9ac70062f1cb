"""Camera back end that renders what a camera would see of the simulated print."""

from __future__ import annotations

from collections.abc import Mapping

from bpc_perception.core.capture import Capture
from bpc_perception.nodes.parameters import NodeConfig
from rclpy.node import Node

from bpc_sim.config import SimConfig
from bpc_sim.print_job import PrintJob


class SyntheticCamera:
    """Sees the print as far as it has come at the time of the capture."""

    def __init__(self, job: PrintJob, start_ns: int) -> None:
        self._job = job
        self._start_ns = start_ns
        self._number = 0

    def due(self, now_ns: int) -> bool:
        """Never: it is asked for captures."""
        del now_ns
        return False

    def capture(self, now_ns: int) -> Capture:
        """The capture of this moment."""
        t = (now_ns - self._start_ns) * 1e-9
        capture = self._job.capture(t, self._number, now_ns)
        self._number += 1
        return capture

    def notes(self) -> Mapping[str, object]:
        """Nothing."""
        return {}

    def close(self) -> None:
        """Nothing is held."""


def open_camera(node: Node) -> SyntheticCamera:
    """The camera for the print that the node's parameters name."""
    config = NodeConfig(node, SimConfig()).value
    return SyntheticCamera(config.job(), config.start_time_ns)
