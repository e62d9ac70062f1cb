"""What a node did and refused, and whether its inputs go on, on /diagnostics."""

from __future__ import annotations

from collections import Counter
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from bpc_perception.core.config import WatchConfig
from bpc_perception.core.watch.input_watch import InputWatch, Level
from bpc_perception.runtime.clock import steady_clock

PERIOD = 1.0  # while nothing changes [s]
LOOK = 0.05  # how late it is seen that something did [s]
WORSE = (Level.OK, Level.STALE, Level.WARN, Level.ERROR)
SAYS = {Level.STALE: 'expected messages, heard of none yet',
        Level.WARN: 'expected messages, found silence',
        Level.ERROR: 'expected messages, found lasting silence'}


class Diagnostics:
    """Counts events and refusals of a node, watches its inputs, and publishes once a second.

    At once is published what changes of an input's level, and what is refused or warned of for the
    first time in a second. The level is that of the worst input, or WARN if that is worse and
    something was refused or warned of since the last time.
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
        self._news: dict[str, str] = {}  # by kind
        self._told: dict[str, float] = {}  # when a kind was last among the news [s], steady
        self._levels: dict[str, Level] = {}  # as published
        self._last_refusal = self._last_warning = ''
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
        self._refusals[self._add_news(text)] += 1
        self._last_refusal = text
        self._node.get_logger().warning(text, throttle_duration_sec=1.0)

    def warn(self, text: str) -> None:
        """Say what is not as it should be, though nothing had to be refused."""
        self._add_news(text)
        self._last_warning = text
        self._node.get_logger().warning(text, throttle_duration_sec=10.0)

    def expect(self, name: str, paced: bool = False) -> None:
        """Watch an input from now on; see InputWatch."""
        self._inputs[name] = InputWatch(self._config, paced)

    def heard(self, name: str) -> None:
        """Take note of a message of a watched input, whatever is in it."""
        self._inputs[name].heard(time.monotonic())

    def _add_news(self, text: str) -> str:
        kind = text.split(':')[0]
        self._news[kind] = text
        return kind

    def _look(self) -> None:
        now = time.monotonic()
        times = [self._published, *(self._told.get(kind, -PERIOD) for kind in self._news)]
        if now - min(times) >= PERIOD or self._input_levels(now) != self._levels:
            self.publish()

    def _input_levels(self, now: float) -> dict[str, Level]:
        return {name: watched.level(now) for name, watched in self._inputs.items()}

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
        self._levels = self._input_levels(now)
        silent = {level: [name for name, found in self._levels.items() if found == level]
                  for level in reversed(WORSE)}
        wrong = [f'{", ".join(names)}: {SAYS[level]}' for level, names in silent.items()
                 if names and level != Level.OK]
        worst = max((Level.WARN if self._news else Level.OK, *self._levels.values()),
                    key=WORSE.index)
        self._published, self._published_counts = now, self._counts.copy()
        status = DiagnosticStatus(
            level=bytes([worst]), name=self._node.get_name(),
            message='; '.join([*wrong, *self._news.values()]) or 'ok',
            hardware_id=self._hardware_id, values=values)
        self._told.update(dict.fromkeys(self._news, now))
        self._news.clear()
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)
