"""The synthetic robot as the LBR stack has it: joint states only."""

from __future__ import annotations

from array import array
from typing import Any

from bpc_perception.conversions import ns_to_stamp
from bpc_perception.core.kinematics import JOINTS
from bpc_perception.nodes.parameters import NodeConfig
from bpc_perception.nodes.run import run
from rclpy.node import Node
from sensor_msgs.msg import JointState

from bpc_perception import topics
from bpc_sim.arm import Arm
from bpc_sim.config import SimConfig


class SyntheticArmNode(Node):
    """Publishes ``joint_states`` of an LBR Med 7 that prints."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('synthetic_arm', **kwargs)
        self._config = NodeConfig(self, SimConfig()).value
        self._job = self._config.job()
        self._arm = Arm()
        self._joint_states = self.create_publisher(
            JointState, topics.JOINTS, topics.EXTRUSION_QOS)
        self.create_timer(1.0 / self._config.pose_rate, self._publish)

    def _publish(self) -> None:
        now_ns = self.get_clock().now().nanoseconds
        t = (now_ns - self._config.start_time_ns) * 1e-9
        angles = self._arm.reach(self._job.flange_pose(t))
        message = JointState(name=[f'lbr_{joint}' for joint in JOINTS],
                             position=array('d', angles.tolist()))
        message.header.stamp = ns_to_stamp(now_ns)
        self._joint_states.publish(message)


def main() -> None:
    """Run the node."""
    run(SyntheticArmNode)


if __name__ == '__main__':
    main()
