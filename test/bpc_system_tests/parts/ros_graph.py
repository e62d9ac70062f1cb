"""ROS graphs whose nodes are processes, with the test as a listener among them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
import os
from typing import Any, ClassVar

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.qos import QoSProfile

from bpc_interfaces.msg import DepositionPath, RateAdvice, ThicknessProfile
from bpc_perception.messages import topics
from bpc_perception.runtime.child_processes import Nodes
from bpc_perception.runtime.isolated_graph import free_domain, Graph

PATIENCE = 60.0  # for what takes a few seconds on an idle machine [s]


def start_delay(took: float) -> float:
    """How far ahead the start of a print is set [s], if other nodes took so long to start."""
    return max(6.0, 2 * took)


@contextmanager
def own_domain() -> Iterator[int]:
    """A ROS domain id that no other test has, which processes started meanwhile inherit."""
    before = os.environ.get('ROS_DOMAIN_ID')
    with free_domain() as domain:
        os.environ['ROS_DOMAIN_ID'] = str(domain)
        try:
            yield domain
        finally:
            del os.environ['ROS_DOMAIN_ID']
            if before is not None:
                os.environ['ROS_DOMAIN_ID'] = before


class Listener:
    """A node of the test's that keeps what the nodes under test say, by arrival.

    Attributes:
        heard: messages of each topic in the order in which they came.
        order: the topics of all messages in the order in which they came.
    """

    TOPICS: ClassVar[dict[str, tuple[Any, QoSProfile]]] = {
        topics.PROFILE: (ThicknessProfile, topics.RESULT_QOS),
        topics.ADVICE: (RateAdvice, topics.RESULT_QOS),
        topics.PATH: (DepositionPath, topics.PATH_QOS),
        '/diagnostics': (DiagnosticArray, QoSProfile(depth=100)),
    }

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self.node = graph.make(Node, 'listener')
        self.heard: dict[str, list[Any]] = {name: [] for name in self.TOPICS}
        self.order: list[str] = []
        for name, (kind, qos) in self.TOPICS.items():
            self.node.create_subscription(kind, name, partial(self._hear, name), qos)

    def _hear(self, name: str, message: Any) -> None:
        self.heard[name].append(message)
        self.order.append(name)

    def forget(self) -> None:
        """Begin anew."""
        for messages in self.heard.values():
            messages.clear()
        self.order.clear()

    @property
    def profiles(self) -> list[ThicknessProfile]:
        """The profiles that came."""
        return self.heard[topics.PROFILE]

    @property
    def advice(self) -> list[RateAdvice]:
        """The advice that came."""
        return self.heard[topics.ADVICE]

    def wait(self, condition: Callable[[], Any], nodes: Nodes | None = None,
             timeout: float = PATIENCE) -> None:
        """Listen until the condition holds; fails when a node ends before, or it never does.

        What the nodes last said on /diagnostics is then said as well.
        """
        def holds() -> Any:
            if nodes is not None:
                nodes.check()
            return condition()

        try:
            self._graph.spin_until(holds, timeout)
        except AssertionError as error:
            raise AssertionError(f'{error}; {self.last_words()}') from None

    def last_words(self) -> dict[str, str]:
        """What each node last said on /diagnostics, with all its values."""
        return {status.name: f'{status.message}: ' + ', '.join(
                    f'{value.key} {value.value}' for value in status.values)
                for message in self.heard['/diagnostics'] for status in message.status}

    def complaints(self, node: str) -> list[str]:
        """What a node said on /diagnostics that it had to refuse."""
        return [status.message for message in self.heard['/diagnostics']
                for status in message.status
                if status.name == node and status.level != DiagnosticStatus.OK]


@contextmanager
def listening(domain: int) -> Iterator[Listener]:
    """A listener in a graph."""
    graph = Graph(domain)
    try:
        yield Listener(graph)
    finally:
        graph.close()
