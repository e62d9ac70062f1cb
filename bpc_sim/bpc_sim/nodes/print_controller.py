"""A print controller that follows advice and schedule: the example of how to use both."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import PoseStamped
import numpy as np
from rclpy.node import Node
from std_msgs.msg import Float64

from bpc_interfaces.msg import ExtrusionState, RateAdvice, RateSchedule
from bpc_perception.messages import topics
from bpc_perception.messages.poses.pose import pose_to_matrix
from bpc_perception.messages.results.advice import advice_from_message
from bpc_perception.messages.results.schedule import schedule_from_message
from bpc_perception.messages.stamps import ConversionError
from bpc_perception.runtime.diagnostics import Diagnostics
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.run import run
from bpc_sim.closed_loop.controllers import AdviceFollower, FLOW_SCALE, SPEED_SCALE
from bpc_sim.config import ControllerConfig

COMMAND_RATE_HZ = 20.0
LAYER = 0  # that is printed


class PrintControllerNode(Node):
    """Commands the factor on the nominal flow or speed; see docs/reference/nodes.

    It prints one layer. Its place there is how far the flange has gone since ink was pushed out
    first: the tool does not turn. A controller that has its own program knows it better.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('print_controller', **kwargs)
        actuator = NodeConfig(self, ControllerConfig()).value.actuator
        self._follower = AdviceFollower(actuator)
        self._diagnostics = Diagnostics(self)
        self._commands = self.create_publisher(
            Float64, FLOW_SCALE if actuator == 'flow' else SPEED_SCALE, topics.RESULT_QOS)
        self.create_subscription(RateAdvice, topics.ADVICE, self._on_advice, topics.RESULT_QOS)
        self._place, self._flange = 0.0, np.full(3, np.nan)
        self._pushing = False
        if actuator == 'flow':
            for kind, topic, take, qos in (
                    (RateSchedule, topics.SCHEDULE, self._on_schedule, topics.SCHEDULE_QOS),
                    (ExtrusionState, topics.EXTRUSION, self._on_extruder, topics.EXTRUSION_QOS),
                    (PoseStamped, topics.POSE, self._on_pose, topics.EXTRUSION_QOS)):
                self.create_subscription(kind, topic, take, qos)
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

    def _on_schedule(self, message: RateSchedule) -> None:
        try:
            told = schedule_from_message(message)
        except ConversionError as error:
            self._diagnostics.refuse(error)
            return
        self._diagnostics.count('schedules')
        self._follower.plan(told.schedule if told.layer == LAYER else None, self._now_ns())

    def _on_extruder(self, message: ExtrusionState) -> None:
        self._pushing |= bool(message.extruding)

    def _on_pose(self, message: PoseStamped) -> None:
        before, self._flange = self._flange, pose_to_matrix(message.pose)[:3, 3]
        if self._pushing:
            self._place += float(np.linalg.norm(np.nan_to_num(self._flange - before)))

    def _command(self) -> None:
        self._commands.publish(Float64(data=self._follower.scale(self._now_ns(), self._place)))

    def _now_ns(self) -> int:
        return int(self.get_clock().now().nanoseconds)


def main() -> None:
    """Run the node."""
    run(PrintControllerNode)


if __name__ == '__main__':
    main()
