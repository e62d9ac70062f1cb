"""Publish on /diagnostics what a node did and refused, and whether its inputs go on."""

from __future__ import annotations

from collections import Counter
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from bpc_perception.core.config import WatchConfig
from bpc_perception.core.watch.input_watch import InputWatch, Level
from bpc_perception.display.plain_text import one_line
from bpc_perception.runtime.clock import steady_clock

PUBLISH_PERIOD_S = 1.0  # while nothing changes
CHECK_PERIOD_S = 0.05  # a change is seen this much late
BY_SEVERITY = (Level.OK, Level.STALE, Level.WARN, Level.ERROR)
MEANINGS = {Level.STALE: 'expected messages, heard of none yet',
            Level.WARN: 'expected messages, found silence',
            Level.ERROR: 'expected messages, found lasting silence'}


def in_words(error: Exception) -> str:
    """Return an error as the reason of a refusal; one of memory has few words by itself."""
    if isinstance(error, MemoryError):
        return f'memory: expected enough for this, found no more: {error}'.removesuffix(': ')
    return str(error)


class Diagnostics:
    """Counts events and refusals of a node, watches its inputs, and publishes once a second.

    Two things are published at once: a change of the level of an input, and a kind of refusal or
    warning that was not published within the last second. The level is that of the worst input,
    or WARN if that is worse and there was a refusal or warning since the last message.
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
        self._news: dict[str, str] = {}  # unpublished refusals and warnings, by kind
        self._told: dict[str, float] = {}  # when a kind was last published [s], steady
        self._levels: dict[str, Level] = {}  # of the inputs, as published
        self._last_refusal = self._last_warning = self._waiting = ''
        self._published, self._published_counts = time.monotonic(), Counter[str]()
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        # Steady time: a node has to go on publishing this while its clock stands still.
        self._timer = node.create_timer(CHECK_PERIOD_S, self._check, clock=steady_clock())

    def count(self, event: str, times: int = 1) -> None:
        """Count an event that is no fault."""
        if times:
            self._counts[event] += times

    def wait_for(self, text: str) -> None:
        """Say what is waited for, which is no fault; it is gone with the next state."""
        self._waiting = one_line(text)
        self._node.get_logger().info(self._waiting, throttle_duration_sec=10.0)

    def note(self, key: str, value: object) -> None:
        """Set a value that describes the state."""
        self._notes[key] = str(value)

    def refuse(self, reason: object) -> None:
        """Count input that cannot be used; the words before the first colon are its kind."""
        text = one_line(str(reason))
        self._refusals[self._add_news(text)] += 1
        self._last_refusal = text
        self._node.get_logger().warning(text, throttle_duration_sec=1.0)

    def warn(self, text: str) -> None:
        """Warn of something that is wrong, though nothing had to be refused."""
        text = one_line(text)
        self._add_news(text)
        self._last_warning = text
        self._node.get_logger().warning(text, throttle_duration_sec=10.0)

    def expect(self, name: str, paced: bool = False) -> None:
        """Watch an input from now on; see InputWatch."""
        self._inputs[name] = InputWatch(self._config, paced)

    def heard(self, name: str) -> None:
        """Note that a message of a watched input came, usable or not."""
        self._inputs[name].heard(time.monotonic())

    def publish(self) -> None:
        """Publish the state now."""
        now = time.monotonic()
        values = [*self._describe_events(now), *self._describe_inputs(now)]
        self._levels = self._input_levels(now)
        worst = max((Level.WARN if self._news else Level.OK, *self._levels.values()),
                    key=BY_SEVERITY.index)
        status = DiagnosticStatus(
            level=bytes([worst]), name=self._node.get_name(),
            message='; '.join([*self._silent_inputs(), *self._news.values()])
            or self._waiting or 'ok',
            hardware_id=self._hardware_id,
            values=[KeyValue(key=key, value=value) for key, value in values])
        self._published, self._published_counts = now, self._counts.copy()
        self._told.update(dict.fromkeys(self._news, now))
        self._news.clear()
        self._waiting = ''
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)

    def _check(self) -> None:
        now = time.monotonic()
        times = [self._published,
                 *(self._told.get(kind, -PUBLISH_PERIOD_S) for kind in self._news)]
        if now - min(times) >= PUBLISH_PERIOD_S or self._input_levels(now) != self._levels:
            self.publish()

    def _add_news(self, text: str) -> str:
        kind = text.split(':')[0]
        self._news[kind] = text
        return kind

    def _input_levels(self, now: float) -> dict[str, Level]:
        return {name: watched.level(now) for name, watched in self._inputs.items()}

    def _silent_inputs(self) -> list[str]:
        """Return the silent inputs in words, the worst first."""
        silent = {level: [name for name, found in self._levels.items() if found == level]
                  for level in reversed(BY_SEVERITY) if level != Level.OK}
        return [f'{", ".join(names)}: {MEANINGS[level]}'
                for level, names in silent.items() if names]

    def _describe_events(self, now: float) -> list[tuple[str, str]]:
        """Return notes, counts and rates since the last message, as keys and values."""
        elapsed = max(now - self._published, 1e-9)
        values = list(self._notes.items())
        for event, count in self._counts.items():
            rate = (count - self._published_counts[event]) / elapsed
            values += [(event, str(count)), (f'rate: {event} [1/s]', f'{rate:.1f}')]
        return values

    def _describe_inputs(self, now: float) -> list[tuple[str, str]]:
        """Return the ages of inputs, and what was refused and warned of, as keys and values."""
        values = []
        for name, watched in self._inputs.items():
            age = watched.age(now)
            values.append((f'age: {name} [s]', 'none' if age is None else f'{age:.2f}'))
        values += [(f'refused: {kind}', str(count)) for kind, count in self._refusals.items()]
        if self._last_refusal:
            values.append(('last refusal', self._last_refusal))
        if self._last_warning:
            values.append(('last warning', self._last_warning))
        return values
