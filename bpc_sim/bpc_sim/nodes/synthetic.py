"""A node that publishes one kind of message of a simulated print at a steady rate."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from bpc_perception.messages import topics
from bpc_perception.runtime.parameters import NodeConfig
from bpc_sim.config import SimConfig
from bpc_sim.nodes.steady_rate import SteadyRate
from bpc_sim.printer.print_job import PrintJob


class SyntheticNode(Node):
    """Re-enacts its part of the print from the clock alone, so that all parts agree.

    It publishes at ``rate``, or at that of the robot where there is none.
    """

    def __init__(self, name: str, topic: str, rate: float | None,
                 message_at: Callable[[PrintJob, float, int], Any], **kwargs: Any) -> None:
        super().__init__(name, **kwargs)
        self._config = NodeConfig(self, SimConfig()).value
        self._job = self._config.job()
        self._message_at = message_at
        # Reliable offers also serve those who ask for sensor data, best effort.
        self._publisher = self.create_publisher(
            topics.PRINT[topic], topic, topics.EXTRUSION_QOS)
        rate = rate or self._config.pose_rate
        self._rate = SteadyRate(rate)
        self.create_timer(1.0 / rate, self._publish)

    def _publish(self) -> None:
        for stamp_ns in self._rate.due(self.get_clock().now().nanoseconds):
            t = (stamp_ns - self._config.start_time_ns) * 1e-9
            self._publisher.publish(self._message_at(self._job, t, stamp_ns))
