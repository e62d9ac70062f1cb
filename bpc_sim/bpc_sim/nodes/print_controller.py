"""A print controller that follows rate advice: the example of how to use it."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from std_msgs.msg import Float64

from bpc_interfaces.msg import RateAdvice
from bpc_perception.messages import topics
from bpc_perception.messages.advice import advice_from_message
from bpc_perception.messages.stamps import ConversionError
from bpc_perception.runtime.diagnostics import Diagnostics
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.run import run
from bpc_sim.closed_loop.controllers import AdviceFollower, FLOW_SCALE, SPEED_SCALE
from bpc_sim.config import ControllerConfig

COMMAND_RATE_HZ = 20.0


class PrintControllerNode(Node):
    """Commands the factor on the nominal flow or speed; see docs/reference/nodes."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('print_controller', **kwargs)
        actuator = NodeConfig(self, ControllerConfig()).value.actuator
        self._follower = AdviceFollower(actuator)
        self._diagnostics = Diagnostics(self)
        self._commands = self.create_publisher(
            Float64, FLOW_SCALE if actuator == 'flow' else SPEED_SCALE, topics.RESULT_QOS)
        self.create_subscription(RateAdvice, topics.ADVICE, self._on_advice, topics.RESULT_QOS)
        self.create_timer(1.0 / COMMAND_RATE_HZ, self._command)

    def _on_advice(self, message: RateAdvice) -> None:
        try:
            advice = advice_from_message(message)
        except ConversionError as error:
            self._diagnostics.refuse(error)
            return
        self._diagnostics.count('advice')
        self._follower.take(None, advice, self._now_ns())
        self._command()

    def _command(self) -> None:
        self._commands.publish(Float64(data=self._follower.scale(self._now_ns(), 0.0)))

    def _now_ns(self) -> int:
        return int(self.get_clock().now().nanoseconds)


def main() -> None:
    """Run the node."""
    run(PrintControllerNode)


if __name__ == '__main__':
    main()
