"""ROS graphs of processes, with the test as a listener among them."""

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
from bpc_system_tests.parts.command_line import PATIENCE_S

SHORTEST_START_DELAY_S = 10.0


def start_delay(took: float) -> float:
    """Return how far ahead to set the start of a print [s], if nodes took so long to start."""
    return max(SHORTEST_START_DELAY_S, 3 * took)


@contextmanager
def own_domain() -> Iterator[int]:
    """Reserve a ROS domain id; processes that start in the block inherit it."""
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
    """A node of the test that keeps the messages of the nodes under test.

    Attributes:
        heard: messages of each topic, in the order of arrival.
        order: topics of all messages, in the order of arrival.
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
        """Forget all messages."""
        for messages in self.heard.values():
            messages.clear()
        self.order.clear()

    @property
    def profiles(self) -> list[ThicknessProfile]:
        """The profiles that arrived."""
        return self.heard[topics.PROFILE]

    @property
    def advice(self) -> list[RateAdvice]:
        """The advice that arrived."""
        return self.heard[topics.ADVICE]

    def wait(self, condition: Callable[[], Any], nodes: Nodes | None = None,
             timeout: float = PATIENCE_S) -> None:
        """Listen until a condition holds.

        Fails if one of ``nodes`` ends before, or after the timeout [s]; the failure also says
        what the nodes last said on /diagnostics.
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
        """Return what each node last said on /diagnostics, with all values."""
        return {status.name: f'{status.message}: ' + ', '.join(
                    f'{value.key} {value.value}' for value in status.values)
                for message in self.heard['/diagnostics'] for status in message.status}

    def complaints(self, node: str) -> list[str]:
        """Return the warnings of a node on /diagnostics."""
        return [status.message for message in self.heard['/diagnostics']
                for status in message.status
                if status.name == node and status.level != DiagnosticStatus.OK]


@contextmanager
def listening(domain: int) -> Iterator[Listener]:
    """Make a listener in the graph of a domain."""
    graph = Graph(domain)
    try:
        yield Listener(graph)
    finally:
        graph.close()
