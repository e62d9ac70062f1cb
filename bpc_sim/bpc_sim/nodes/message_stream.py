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


class MessageStreamNode(Node):
    """Simulates its part of the print from the clock alone, so that all parts agree.

    Args:
        name: name of the node.
        topic: topic of the messages.
        rate: rate of the messages [Hz]; None = the parameter ``pose_rate``.
        message_at: makes the message from the job, its time [s] and the stamp [ns].
        kwargs: further arguments of the node.
    """

    def __init__(self, name: str, topic: str, rate: float | None,
                 message_at: Callable[[PrintJob, float, int], Any], **kwargs: Any) -> None:
        super().__init__(name, **kwargs)
        self._config = NodeConfig(self, SimConfig()).value
        self._job = self._config.job()
        self._message_at = message_at
        # A reliable publisher also serves subscribers that ask for best effort.
        self._publisher = self.create_publisher(
            topics.PRINT[topic], topic, topics.EXTRUSION_QOS)
        rate = rate or self._config.pose_rate
        self._rate = SteadyRate(rate)
        self.create_timer(1.0 / rate, self._publish)

    def _publish(self) -> None:
        for stamp_ns in self._rate.due(self.get_clock().now().nanoseconds):
            t = (stamp_ns - self._config.start_time_ns) * 1e-9
            self._publisher.publish(self._message_at(self._job, t, stamp_ns))
