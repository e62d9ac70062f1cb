"""The extruder bridge: what the rig's extruder says of itself in, extrusion states out."""

from __future__ import annotations

import math
import time
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.core.config import ExtruderConfig
from bpc_perception.core.extruder.plunger import Plunger, PlungerMotion
from bpc_perception.core.extruder.tic import error_names, ExtruderError, OPERATION_STATES, TicState
from bpc_perception.core.robot.clock_offset import ClockOffset
from bpc_perception.core.watch.back_off import BackOff
from bpc_perception.drivers.extruder import Extruder, open_extruder
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
        self._device_clock = ClockOffset()
        self._extruder: Extruder | None = None
        self._back_off, self._heard = BackOff(), 0.0
        self._last: TicState | None = None
        self._extruding = False
        poll = self._poll
        if self._config.back_end == 'joint_state':
            self.create_subscription(
                JointState, topics.PLUNGER, self._on_joints, topics.POSE_QOS)
            return
        if self._config.back_end == 'bool':
            self._sources = self.create_subscription(
                Bool, topics.EXTRUDING, self._on_bool, topics.RESULT_QOS)
            poll = self._repeat
        else:
            self._connect()
        self.create_timer(1 / self._config.rate, poll, clock=steady_clock())

    def _connect(self) -> None:
        """Open the device, or note when to try again."""
        self._device_clock, self._last = ClockOffset(), None
        self._heard = time.monotonic()
        try:
            self._extruder = open_extruder(self._config, self._diagnostics.refuse)
        except ExtruderError as error:
            self._diagnostics.refuse(error)
            self._back_off.failed(self._heard)
            return
        self._diagnostics.count('times opened')

    def _poll(self) -> None:
        if self._extruder is None:
            if not self._back_off.waiting(time.monotonic()):
                self._connect()
            return
        try:
            states = self._extruder.read()
            silence = time.monotonic() - self._heard
            if not states and silence > self._config.timeout:
                raise ExtruderError('extruder: expected a state each '
                                    f'{self._config.timeout:g} s, found none')
        except ExtruderError as error:
            self._diagnostics.refuse(error)
            self._extruder.close()
            self._extruder = None
            self._back_off.failed(time.monotonic())
            return
        now_ns = self.get_clock().now().nanoseconds
        for state in states:
            self._back_off.succeeded()
            self._heard = time.monotonic()
            stamp_ns = (now_ns if state.device_ns is None
                        else self._device_clock.map(state.device_ns, now_ns))
            self._describe(state)
            self._publish(stamp_ns, self._plunger.motion(state), state.error_status)

    def _describe(self, state: TicState) -> None:
        """What is worth knowing of a state beside the motion, on /diagnostics."""
        last, self._last = self._last, state
        if last is not None and state.device_ns is not None and last.device_ns is not None \
                and state.device_ns < last.device_ns:
            self._diagnostics.warn('extruder: expected its clock to run on, found it started '
                                   'anew: it was reset')
        if last is not None and state.step_mode != last.step_mode:
            self._diagnostics.warn(f'extruder: step mode changed from {last.step_mode} to '
                                   f'{state.step_mode}; its position is carried over')
        if state.error_status:
            self._diagnostics.warn(f'extruder: the motor is stopped: '
                                   f'{error_names(state.error_status)}')
        for key, value in (
                ('operation state', OPERATION_STATES.get(state.operation_state,
                                                         state.operation_state)),
                ('step mode', state.step_mode), ('errors', error_names(state.error_status)),
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
        self._heard = 1.0  # it has said something
        self._repeat()

    def _repeat(self) -> None:
        """Whoever says a bool says it when it changes; it holds as long as he is there."""
        if self._heard and self.count_publishers(topics.EXTRUDING):
            self._publish(self.get_clock().now().nanoseconds, PlungerMotion(
                self._extruding, math.nan, math.nan, math.nan, position_uncertain=True))

    def _publish(self, stamp_ns: int, motion: PlungerMotion, error_status: int = 0) -> None:
        self._states.publish(extruder_to_message(stamp_ns, motion, error_status))
        self._diagnostics.count('states')

    def destroy_node(self) -> None:
        """Let go of the device as well."""
        if self._extruder is not None:
            self._extruder.close()
        super().destroy_node()


def main() -> None:
    """Run the node."""
    run(ExtruderBridgeNode)


if __name__ == '__main__':
    main()
