"""The camera back end ``synthetic``: it renders what a camera would see of the print."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from rclpy.clock import Clock
from rclpy.node import Node

from bpc_perception.core.capture.capture import Capture
from bpc_perception.runtime.parameters import NodeConfig
from bpc_sim.config import SimConfig
from bpc_sim.nodes.closed_loop_camera import ClosedLoopCamera
from bpc_sim.printer.messages import CAMERA_LATENCY_NS
from bpc_sim.printer.print_job import PrintJob


class SyntheticCamera:
    """A camera that sees the print as far as it has come at the time of the capture."""

    def __init__(self, job: PrintJob, start_ns: int) -> None:
        self._job = job
        self._start_ns = start_ns
        self._number = 0

    def connect(self) -> None:
        """Do nothing: the camera is always there."""

    def due(self, now_ns: int) -> bool:
        """Return False: captures are taken on request only."""
        del now_ns
        return False

    def capture(self, now_ns: int) -> Capture:
        """Return the capture of this moment."""
        t = (now_ns - self._start_ns) * 1e-9
        capture = self._job.capture(t, self._number, now_ns)
        self._number += 1
        return capture

    def notes(self) -> Mapping[str, object]:
        """Return no notes."""
        return {}

    def close(self) -> None:
        """Do nothing: there is nothing to release."""


class FinishedPrintCamera(SyntheticCamera):
    """A camera that always sees the finished print: a capture costs a copy, as a real one does.

    The stamp is earlier than the delivery, by the time that a real camera needs for a capture.
    """

    def __init__(self, job: PrintJob, clock: Clock) -> None:
        super().__init__(job, 0)
        self._clock = clock
        self._still = job.capture(job.duration, 0)

    def capture(self, now_ns: int) -> Capture:
        """Return a copy of the rendered capture, stamped as if taken now."""
        del now_ns
        image, cloud = self._still.image.copy(), self._still.cloud.copy()
        stamp_ns = self._clock.now().nanoseconds - CAMERA_LATENCY_NS
        return replace(self._still, stamp_ns=stamp_ns, image=image, cloud=cloud)


def prepare(node: Node) -> Callable[[], SyntheticCamera | ClosedLoopCamera]:
    """Return a function that opens a camera for the print in the node's parameters."""
    config = NodeConfig(node, SimConfig()).value
    if config.situation:
        return lambda: ClosedLoopCamera(node, config.closed_loop_job())
    if config.finished:
        return lambda: FinishedPrintCamera(config.job(), node.get_clock())
    return lambda: SyntheticCamera(config.job(), config.start_time_ns)
