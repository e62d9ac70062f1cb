"""What a node did and refused, and whether its inputs go on, on /diagnostics."""

from __future__ import annotations

from collections import Counter
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from bpc_perception.core.config import WatchConfig
from bpc_perception.core.input_watch import InputWatch, Level
from bpc_perception.nodes.clock import steady_clock

PERIOD = 1.0  # while nothing gets worse [s]
LOOK = 0.05  # how late it is seen that something did [s]
WORSE = (Level.OK, Level.STALE, Level.WARN, Level.ERROR)
SAYS = {Level.STALE: 'expected messages, heard of none yet',
        Level.WARN: 'expected messages, found silence',
        Level.ERROR: 'expected messages, found lasting silence'}


class Diagnostics:
    """Counts events and refusals of a node, watches its inputs, and publishes once a second.

    What gets worse is published at once; better it gets with the second. The level is that of the
    worst input, and WARN in a second in which something was refused or warned of.
    """

    def __init__(self, node: Node, hardware_id: str = 'none',
                 watch: WatchConfig | None = None) -> None:
        self._node = node
        self._hardware_id = hardware_id
        self._config = watch or WatchConfig(warn_after=0.0)
        self._inputs: dict[str, InputWatch] = {}
        self._counts: Counter[str] = Counter()
        self._refusals: Counter[str] = Counter()
        self._notes: dict[str, str] = {}
        self._news: list[str] = []
        self._last_refusal = self._last_warning = ''
        self._level = Level.OK
        self._published, self._published_counts = time.monotonic(), Counter[str]()
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        # Steady time: a node whose clock stands still has to go on saying so.
        self._timer = node.create_timer(LOOK, self._look, clock=steady_clock())

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
        self._last_warning = text
        self._node.get_logger().warning(text, throttle_duration_sec=10.0)

    def expect(self, name: str, paced: bool = False) -> None:
        """Watch an input from now on; see InputWatch."""
        self._inputs[name] = InputWatch(self._config, paced)

    def heard(self, name: str) -> None:
        """Take note of a message of a watched input, whatever is in it."""
        self._inputs[name].heard(time.monotonic())

    def _look(self) -> None:
        level, _ = self._state()
        worse = WORSE.index(level) > WORSE.index(self._level)
        if worse or time.monotonic() - self._published >= PERIOD:
            self.publish()

    def _state(self) -> tuple[Level, str]:
        """The level, and what is to be said: news first, silence goes on being said."""
        now = time.monotonic()
        levels = {name: watched.level(now) for name, watched in self._inputs.items()}
        name, level = max(levels.items(), key=lambda each: WORSE.index(each[1]),
                          default=('', Level.OK))
        if self._news:
            return max(Level.WARN, level, key=WORSE.index), self._news[-1]
        return level, 'ok' if level == Level.OK else f'{name}: {SAYS[level]}'

    def publish(self) -> None:
        """Publish the state now."""
        now = time.monotonic()
        elapsed = max(now - self._published, 1e-9)
        values = [KeyValue(key=key, value=value) for key, value in self._notes.items()]
        for event, count in self._counts.items():
            rate = (count - self._published_counts[event]) / elapsed
            values += [KeyValue(key=event, value=str(count)),
                       KeyValue(key=f'rate: {event} [1/s]', value=f'{rate:.1f}')]
        for name, watched in self._inputs.items():
            age = watched.age(now)
            values.append(KeyValue(key=f'age: {name} [s]',
                                   value='none' if age is None else f'{age:.2f}'))
        values += [KeyValue(key=f'refused: {kind}', value=str(count))
                   for kind, count in self._refusals.items()]
        values += [KeyValue(key=key, value=value) for key, value in (
            ('last refusal', self._last_refusal), ('last warning', self._last_warning)) if value]
        self._level, message = self._state()
        self._published, self._published_counts = now, self._counts.copy()
        self._news.clear()
        status = DiagnosticStatus(level=bytes([self._level]), name=self._node.get_name(),
                                  message=message, hardware_id=self._hardware_id, values=values)
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)
