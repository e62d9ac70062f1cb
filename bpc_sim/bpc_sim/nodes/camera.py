"""Camera back end that renders what a camera would see of the simulated print."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from rclpy.clock import Clock
from rclpy.node import Node

from bpc_perception.core.capture.capture import Capture
from bpc_perception.runtime.parameters import NodeConfig
from bpc_sim.closed_loop.camera import ClosedLoopCamera
from bpc_sim.config import SimConfig
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.recording import CAMERA_LATENCY_NS


class SyntheticCamera:
    """Sees the print as far as it has come at the time of the capture."""

    def __init__(self, job: PrintJob, start_ns: int) -> None:
        self._job = job
        self._start_ns = start_ns
        self._number = 0

    def connect(self) -> None:
        """It is there."""

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


class FinishedPrintCamera(SyntheticCamera):
    """Sees the finished print, always: what it delivers costs a copy, as with a real camera.

    The stamp is from before the capture is at hand, by the time that a camera takes for it.
    """

    def __init__(self, job: PrintJob, clock: Clock) -> None:
        super().__init__(job, 0)
        self._clock = clock
        self._still = job.capture(job.duration, 0)

    def capture(self, now_ns: int) -> Capture:
        """A copy, as of now."""
        del now_ns
        image, cloud = self._still.image.copy(), self._still.cloud.copy()
        stamp_ns = self._clock.now().nanoseconds - CAMERA_LATENCY_NS
        return replace(self._still, stamp_ns=stamp_ns, image=image, cloud=cloud)


def prepare(node: Node) -> Callable[[], SyntheticCamera | ClosedLoopCamera]:
    """What opens a camera for the print that the node's parameters name."""
    config = NodeConfig(node, SimConfig()).value
    if config.situation:
        return lambda: ClosedLoopCamera(node, config.closed_loop_job())
    if config.finished:
        return lambda: FinishedPrintCamera(config.job(), node.get_clock())
    return lambda: SyntheticCamera(config.job(), config.start_time_ns)
