"""Read stamped poses of the flange from the messages of any robot."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import Pose, PoseStamped
from sensor_msgs.msg import JointState

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import PoseConfig
from bpc_perception.core.robot.clock_offset import ClockOffset
from bpc_perception.core.robot.kinematics import may_be_arm
from bpc_perception.messages import topics
from bpc_perception.messages.poses.pose import (
    joints_to_matrix,
    lbr_state_to_matrix,
    pose_to_matrix,
)
from bpc_perception.messages.stamps import check_frame, ConversionError, stamp_to_ns
from bpc_perception.messages.types import message_type

LBR_STATE_TYPE = 'lbr_fri_idl/msg/LBRState'  # no wheel of its package exists


class FlangePoses:
    """Reads the messages of one source of poses.

    Attributes:
        topic: relative name of its topic.
        message_class: class of its messages.
    """

    def __init__(self, config: PoseConfig, base_frame: str) -> None:
        """Raises MessageTypeError when the messages of the source are not installed."""
        self._config = config
        self._base_frame = base_frame
        self._controller = ClockOffset()
        # Only tf2 follows the messages of tf; a recording has the path instead.
        self.topic = {'joint_states': topics.JOINTS, 'lbr_state': topics.LBR_STATE,
                      'tf': '/tf'}.get(config.source, topics.POSE)
        self.message_class: Any = {'pose': Pose, 'joint_states': JointState}.get(
            config.source, PoseStamped)
        if config.source == 'lbr_state':
            self.message_class = message_type(LBR_STATE_TYPE)

    def concerns(self, message: Any) -> bool:
        """Return whether a message is of the robot: other joints may be published beside it."""
        return self._config.source != 'joint_states' or may_be_arm(message.name)

    def read(self, message: Any, received_ns: int) -> tuple[int, Array]:
        """Return stamp [ns] and T_base_flange (4, 4) [m] of a message received at this time.

        Raises ConversionError.
        """
        source, robot = self._config.source, self._config.robot
        if source == 'pose':  # has neither stamp nor frame
            return received_ns, pose_to_matrix(message)
        if source == 'lbr_state':  # has a stamp of the clock of the robot's controller
            controller_ns, T_base_flange = lbr_state_to_matrix(message, robot)
            controller_stamp_ns = self._controller.map(controller_ns, received_ns)
            if controller_stamp_ns is None:
                raise ConversionError('lbr_state: expected messages without much delay, found '
                                      'one held up, or a clock that was set'
                                      '; look for a busy computer or network')
            return controller_stamp_ns, T_base_flange
        stamp_ns = stamp_to_ns(message.header.stamp)
        if source == 'joint_states':
            if stamp_ns == 0:
                raise ConversionError('joint_states: expected a stamp, found 0'
                                      "; let the robot's driver stamp them")
            return stamp_ns, joints_to_matrix(message, robot)
        check_frame('pose', message, self._base_frame)
        return stamp_ns, pose_to_matrix(message.pose)
