"""The extruder bridge: takes what the extruder of the rig says, publishes extrusion states."""

from __future__ import annotations

import math
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.core.config import ExtruderConfig
from bpc_perception.core.extruder.plunger import Plunger, PlungerMotion
from bpc_perception.core.extruder.tic import error_names, OPERATION_STATES, TicState
from bpc_perception.core.robot.clock_offset import ClockOffset
from bpc_perception.drivers.extruders.connection import ExtruderConnection
from bpc_perception.messages import topics
from bpc_perception.messages.extruder import extruder_to_message, joint_motion
from bpc_perception.messages.stamps import ConversionError, stamp_to_ns
from bpc_perception.runtime.clock import steady_clock
from bpc_perception.runtime.diagnostics import Diagnostics
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.run import run


class ExtruderBridgeNode(Node):
    """Publishes the state of the extruder; see docs/reference/nodes."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('extruder_bridge', **kwargs)
        self._config = NodeConfig(self, ExtruderConfig()).value
        self._plunger = Plunger(self._config.plunger)
        self._diagnostics = Diagnostics(self, hardware_id=self._config.back_end)
        self._states = self.create_publisher(
            ExtrusionState, topics.EXTRUSION, topics.EXTRUSION_QOS)
        self._connection: ExtruderConnection | None = None
        self._device_clock = ClockOffset()
        self._last: TicState | None = None  # of this connection
        self._extruding: bool | None = None  # as the last Bool says
        if self._config.back_end == 'joint_state':
            self.create_subscription(
                JointState, topics.PLUNGER, self._on_joints, topics.POSE_QOS)
        elif self._config.back_end == 'bool':
            self.create_subscription(Bool, topics.EXTRUDING, self._on_bool, topics.RESULT_QOS)
            self.create_timer(1 / self._config.rate, self._repeat, clock=steady_clock())
        else:
            self._connection = ExtruderConnection(
                self._config, self._diagnostics.refuse, self._on_open)
            self.create_timer(1 / self._config.rate, self._poll, clock=steady_clock())

    def _on_open(self) -> None:
        """Begin anew: the clock of the device may have been set, or the device been replaced."""
        self._device_clock, self._last = ClockOffset(), None
        self._diagnostics.count('times opened')

    def _poll(self) -> None:
        assert self._connection is not None
        states = self._connection.poll()
        now_ns = self.get_clock().now().nanoseconds
        for state in states:
            if self._is_repeated(state):
                continue
            stamp_ns = (now_ns if state.device_ns is None
                        else self._device_clock.map(state.device_ns, now_ns))
            if self._last is not None:
                self._warn_of_changes(self._last, state)
            self._last = state
            self._describe(state)
            if stamp_ns is None:
                self._diagnostics.refuse('extruder: expected lines without much delay, found '
                                         'one held up, or a clock that was set'
                                         '; look for a busy computer')
                continue
            self._publish(stamp_ns, self._plunger.motion(state), state.error_status)

    def _is_repeated(self, state: TicState) -> bool:
        """Return whether the device has said this: no time has passed on its clock."""
        repeated = (self._last is not None and state.device_ns is not None
                    and state.device_ns == self._last.device_ns)
        if repeated:
            self._diagnostics.count('repeated')
        return repeated

    def _warn_of_changes(self, last: TicState, state: TicState) -> None:
        if (state.device_ns is not None and last.device_ns is not None
                and state.device_ns < last.device_ns):
            self._diagnostics.warn('extruder: expected its clock to run on, found it started '
                                   'anew: it was reset; home it')
        if state.step_mode != last.step_mode:
            self._diagnostics.warn(f'extruder: step mode changed from {last.step_mode} to '
                                   f'{state.step_mode}; its position is carried over')

    def _describe(self, state: TicState) -> None:
        """Put on /diagnostics what is useful to know of a state beside the motion."""
        errors = error_names(state.error_status)
        if state.error_status:
            self._diagnostics.warn(f'extruder: the motor is stopped: {errors}'
                                   '; clear the error at the driver')
        for key, value in (
                ('operation state', OPERATION_STATES.get(state.operation_state,
                                                         state.operation_state)),
                ('step mode', state.step_mode), ('errors', errors),
                ('errors occurred', error_names(state.errors_occurred)),
                ('supply [V]', state.vin_mv / 1000)):
            self._diagnostics.note(key, value)

    def _on_joints(self, message: JointState) -> None:
        try:
            motion = self._plunger.moving(*joint_motion(message, self._config.joint))
        except ConversionError as error:
            self._diagnostics.refuse(error)
            return
        self._publish(stamp_to_ns(message.header.stamp), motion)

    def _on_bool(self, message: Bool) -> None:
        self._extruding = bool(message.data)
        self._repeat()

    def _repeat(self) -> None:
        """Publish the last Bool: it is sent on change, and holds as long as it has a sender."""
        if self._extruding is not None and self.count_publishers(topics.EXTRUDING):
            self._publish(self.get_clock().now().nanoseconds, PlungerMotion(
                self._extruding, math.nan, math.nan, math.nan, position_uncertain=True))

    def _publish(self, stamp_ns: int, motion: PlungerMotion, error_status: int = 0) -> None:
        self._states.publish(extruder_to_message(stamp_ns, motion, error_status))
        self._diagnostics.count('states')

    def destroy_node(self) -> None:
        """Close the device as well."""
        if self._connection is not None:
            self._connection.close()
        super().destroy_node()


def main() -> None:
    """Run the node."""
    run(ExtruderBridgeNode)


if __name__ == '__main__':
    main()
