"""Start nodes again that died, and report each death on /diagnostics at once."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from bpc_perception.core.watch.back_off import BackOff
from bpc_perception.runtime.child_processes import NodeError, Nodes
from bpc_perception.runtime.exit_status import REFUSED
from bpc_perception.runtime.transport import shared_memory

QUIET_TIME_S = 0.2  # a node gives a sign of life each 0.1 s, unless it is busy
# Then a node hangs: no start takes as long, nor the measurement of a capture, even after a print
# of 100 m.
HANG_TIME_S = 60.0
MOST_DEATHS, DEATHS_WITHIN_S = 3, 60.0  # this many deaths in this time are no accident
PUBLISH_PERIOD_S = 1.0  # of the diagnostics while nothing changes


@dataclass
class _Life:
    """The history of a node.

    Attributes:
        back_off: when it may be started again.
        level: as published on /diagnostics.
        ran: whether it ever gave a sign of life, so its parameters were accepted.
        dead: whether it waits to be started again.
        deaths: their number.
        last_death: time of the last one [s], steady.
        cause: of the last one.
    """

    back_off: BackOff = field(default_factory=BackOff)
    level: bytes = DiagnosticStatus.OK
    ran: bool = False
    dead: bool = False
    deaths: int = 0
    last_death: float = 0.0
    cause: str = ''


class Supervisor:
    """Keeps nodes running; reports on /diagnostics which run, are quiet, or died, and why.

    A node that ends, is killed or hangs is started again after a pause that grows. A node that
    refuses to start and never ran is not started twice. Three deaths within a minute end all.
    """

    def __init__(self, nodes: Nodes, node: Node) -> None:
        self._nodes = nodes
        self._node = node
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._lives = {name: _Life() for name in nodes.names}
        self._deaths: deque[tuple[float, str]] = deque(maxlen=MOST_DEATHS)
        self._due = 0.0  # when to publish next at the latest [s], steady

    def check(self) -> None:
        """Check all nodes; call it often. Raises NodeError to end all."""
        now = time.monotonic()
        news = now > self._due
        for name, life in self._lives.items():
            level = self._look_after(name, life, now)
            news |= level != life.level
            life.level = level
        if news:
            self._due = now + PUBLISH_PERIOD_S
            self._publish()

    def _look_after(self, name: str, life: _Life, now: float) -> bytes:
        if life.dead:
            if not life.back_off.waiting(now):
                self._start_again(name, life, now)
            return DiagnosticStatus.ERROR
        silence, spoke = self._nodes.silence(name)
        life.ran |= spoke
        if self._nodes.ended(name):
            self._record_death(name, life, self._nodes.end_of(name), now)
            return DiagnosticStatus.ERROR
        if silence > HANG_TIME_S:
            self._nodes.kill(name)
            self._record_death(name, life, f'hung for {silence:.0f} s', now)
            return DiagnosticStatus.ERROR
        return DiagnosticStatus.OK if spoke and silence <= QUIET_TIME_S else DiagnosticStatus.STALE

    def _start_again(self, name: str, life: _Life, now: float) -> None:
        try:
            self._nodes.start_again(name)
        except OSError as error:  # for instance too many processes; no fault of the node
            life.back_off.failed(now)
            life.cause = f'cannot be started: {error}'
            return
        life.dead = False
        shared_memory.clean()

    def _record_death(self, name: str, life: _Life, cause: str, now: float) -> None:
        if self._nodes.status(name) == REFUSED and not life.ran:
            self._nodes.check()
        self._deaths.append((now, f'{name} {cause}'))
        if len(self._deaths) == MOST_DEATHS and now - self._deaths[0][0] < DEATHS_WITHIN_S:
            raise NodeError(f'expected nodes that live, found {MOST_DEATHS} deaths within '
                            f'{now - self._deaths[0][0]:.0f} s: '
                            + '; '.join(text for _, text in self._deaths))
        if now - life.last_death > DEATHS_WITHIN_S:
            life.back_off.succeeded()
        life.back_off.failed(now)
        life.dead, life.last_death, life.cause = True, now, cause
        life.deaths += 1

    def _status(self, name: str, life: _Life) -> DiagnosticStatus:
        message = {
            DiagnosticStatus.OK: 'ok',
            DiagnosticStatus.STALE: 'no sign of life: it starts, is busy or hangs',
            DiagnosticStatus.ERROR: f'{life.cause}; it is started again, after death '
                                    f'number {life.deaths}'}[life.level]
        values = {'pid': self._nodes.pid(name), 'deaths': life.deaths,
                  'last death': life.cause or 'none'}
        return DiagnosticStatus(
            level=life.level, name=f'supervisor: {name}', message=message, hardware_id='none',
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()])

    def _publish(self) -> None:
        array = DiagnosticArray(
            status=[self._status(name, life) for name, life in self._lives.items()])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)
