"""The synthetic robot."""

from __future__ import annotations

from typing import Any

from bpc_perception.messages import topics
from bpc_perception.runtime.run import run
from bpc_sim.nodes.message_stream import MessageStreamNode
from bpc_sim.printer.messages import robot_message


class SyntheticRobotNode(MessageStreamNode):
    """Publishes ``end_effector_pose`` of a simulated print."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('synthetic_robot', topics.POSE, None, robot_message, **kwargs)


def main() -> None:
    """Run the node."""
    run(SyntheticRobotNode, fast_streams=True)


if __name__ == '__main__':
    main()
