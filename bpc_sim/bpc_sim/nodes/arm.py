"""The synthetic robot in the messages of the LBR stack: joint states and controller state."""

from __future__ import annotations

from array import array
from contextlib import suppress
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState

from bpc_perception.core.robot.kinematics import JOINTS
from bpc_perception.messages import topics
from bpc_perception.messages.poses.flange_poses import LBR_STATE_TYPE
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.messages.types import message_type, MessageTypeError
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.run import run
from bpc_sim.config import SimConfig
from bpc_sim.nodes.steady_rate import SteadyRate
from bpc_sim.printer.arm import Arm

# The controller uses the clock of the cabinet, which nobody has set.
CONTROLLER_BEHIND_NS = 4321 * 10**9


class SyntheticArmNode(Node):
    """Publishes ``joint_states`` of an LBR Med 7 that prints, and ``lbr_state`` if installed."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('synthetic_arm', **kwargs)
        self._config = NodeConfig(self, SimConfig()).value
        self._job = self._config.job()
        self._arm = Arm()
        self._joint_states = self.create_publisher(
            JointState, topics.JOINTS, topics.EXTRUSION_QOS)
        self._lbr_states: Publisher | None = None
        with suppress(MessageTypeError):  # the LBR stack is not installed
            self._lbr_state = message_type(LBR_STATE_TYPE)
            # Deeper than the stack's own: after the process was held up, many are sent at once.
            self._lbr_states = self.create_publisher(
                self._lbr_state, topics.LBR_STATE, topics.EXTRUSION_QOS)
        self._rate = SteadyRate(self._config.pose_rate)
        self.create_timer(1.0 / self._config.pose_rate, self._publish_due)

    def _publish_due(self) -> None:
        for stamp_ns in self._rate.due(self.get_clock().now().nanoseconds):
            self._publish(stamp_ns)

    def _publish(self, now_ns: int) -> None:
        t = (now_ns - self._config.start_time_ns) * 1e-9
        angles = self._arm.joint_angles(self._job.flange_pose(t))
        message = JointState(name=[f'lbr_{joint}' for joint in JOINTS],
                             position=array('d', angles.tolist()))
        message.header.stamp = ns_to_stamp(now_ns)
        self._joint_states.publish(message)
        if self._lbr_states is not None:
            seconds, nanoseconds = divmod(now_ns - CONTROLLER_BEHIND_NS, 10**9)
            self._lbr_states.publish(self._lbr_state(
                time_stamp_sec=seconds, time_stamp_nano_sec=nanoseconds,
                measured_joint_position=angles))


def main() -> None:
    """Run the node."""
    run(SyntheticArmNode)


if __name__ == '__main__':
    main()
