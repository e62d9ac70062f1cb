"""What a node did and refused, on /diagnostics."""

from __future__ import annotations

from collections import Counter

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node


class Diagnostics:
    """Counts events and refusals of a node and publishes them once a second.

    The level is WARN in a second in which something was refused or warned of, otherwise OK.
    """

    def __init__(self, node: Node, hardware_id: str = 'none') -> None:
        self._node = node
        self._hardware_id = hardware_id
        self._counts: Counter[str] = Counter()
        self._refusals: Counter[str] = Counter()
        self._notes: dict[str, str] = {}
        self._news: list[str] = []
        self._last_refusal = ''
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        # Steady time: a node whose clock stands still has to go on saying so.
        self._timer = node.create_timer(1.0, self.publish, clock=Clock(
            clock_type=ClockType.STEADY_TIME))

    def count(self, event: str, times: int = 1) -> None:
        """Count something that went as it should."""
        if times:
            self._counts[event] += times

    def note(self, key: str, value: object) -> None:
        """Keep a value that describes the state, in place of the one before."""
        self._notes[key] = str(value)

    def refuse(self, reason: object) -> None:
        """Count input that cannot be used; the words before the first colon are its kind."""
        text = str(reason)
        kind = text.split(':')[0]
        self._refusals[kind] += 1
        self._news.append(text)
        self._last_refusal = text
        self._node.get_logger().warning(text, throttle_duration_sec=1.0)

    def warn(self, text: str) -> None:
        """Say what is not as it should be, though nothing had to be refused."""
        self._news.append(text)
        self._node.get_logger().warning(text, throttle_duration_sec=10.0)

    def publish(self) -> None:
        """Publish the state now."""
        values = [KeyValue(key=key, value=value) for key, value in self._notes.items()]
        values += [KeyValue(key=key, value=str(count)) for key, count in self._counts.items()]
        values += [KeyValue(key=f'refused: {kind}', value=str(count))
                   for kind, count in self._refusals.items()]
        if self._last_refusal:
            values.append(KeyValue(key='last refusal', value=self._last_refusal))
        level = DiagnosticStatus.WARN if self._news else DiagnosticStatus.OK
        message = self._news[-1] if self._news else 'ok'
        self._news.clear()
        status = DiagnosticStatus(level=level, name=self._node.get_name(), message=message,
                                  hardware_id=self._hardware_id, values=values)
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)
