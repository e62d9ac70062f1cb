"""A synthetic print with the nodes that measure it, as processes in a graph of their own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
import os
from pathlib import Path
import tempfile
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from bpc_interfaces.msg import RateAdvice, ThicknessProfile
from bpc_perception.messages import topics
from bpc_perception.runtime.child_processes import Nodes
from bpc_perception.runtime.isolated_graph import free_domain, Graph
from bpc_sim.config import SimConfig
from bpc_sim.printer.settings import write_settings

TARGET_M = 2e-3  # wanted thickness
START_DELAY_S = 12.0  # in which all nodes start and a full capture is rendered


@dataclass(frozen=True)
class Arrival:
    """A message and when it arrived.

    Attributes:
        time_ns: time of arrival [ns].
        message: the message.
    """

    time_ns: int
    message: Any


class RunningPrint:
    """The running nodes, and the messages heard from them.

    Attributes:
        nodes: the processes.
        tick: called again and again while time passes.
        graph: graph of the benchmark's own node, ``peer``.
        start_ns: when the print starts [ns].
        advice, profiles: arrived messages, in order.
    """

    def __init__(self, graph: Graph, nodes: Nodes, start_ns: int,
                 tick: Callable[[], None]) -> None:
        self.graph, self.nodes, self.start_ns, self.tick = graph, nodes, start_ns, tick
        self.peer: Node = graph.make(Node, 'benchmark')
        self.advice: list[Arrival] = []
        self.profiles: list[Arrival] = []
        self._counts: dict[str, dict[str, int]] = {}
        for kind, name, heard in ((RateAdvice, topics.ADVICE, self.advice),
                                  (ThicknessProfile, topics.PROFILE, self.profiles)):
            self.peer.create_subscription(kind, name, partial(_append, heard), topics.RESULT_QOS)
        self.peer.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 100)

    def count(self, node: str, event: str) -> int:
        """Return the latest count of an event or refusal in a node's diagnostics."""
        return self._counts.get(node, {}).get(event, 0)

    def refusals(self, node: str) -> int:
        """Return how much a node has refused so far."""
        return sum(count for event, count in self._counts.get(node, {}).items()
                   if event.startswith('refused'))

    def listen_until(self, time_ns: int) -> None:
        """Listen until a time [ns]. Raises NodeError if a node ends before."""
        while time.time_ns() < time_ns:
            self.nodes.check()
            self.graph.executor.spin_once(timeout_sec=0.05)
            self.tick()

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._counts[status.name] = {value.key: int(value.value) for value in status.values
                                         if value.value.isdecimal()}


def _append(heard: list[Arrival], message: Any) -> None:
    heard.append(Arrival(time.time_ns(), message))


@contextmanager
def running_print(sim: dict[str, Any], rate: float, separate: bool, robot: bool = True,
                  tick: Callable[[], None] = lambda: None) -> Iterator[RunningPrint]:
    """Run a print that starts ``START_DELAY_S`` from now.

    Args:
        sim: values of SimConfig, without the start time.
        rate: rate of the captures [Hz].
        separate: whether camera driver and thickness node are two processes.
        robot: whether robot and extruder run; otherwise the caller sends poses and states.
        tick: called again and again while time passes.
    """
    start_ns = time.time_ns() + round(START_DELAY_S * 1e9)
    job = SimConfig(**sim).job()
    common = {**sim, 'start_time_ns': start_ns}
    with free_domain() as domain, tempfile.TemporaryDirectory() as folder:
        settings = write_settings(job, TARGET_M, Path(folder))
        os.environ['ROS_DOMAIN_ID'] = str(domain)
        graph = Graph(domain)
        try:
            with Nodes(settings.parameters) as nodes:
                nodes.start('bpc_perception.nodes.path_recorder')
                nodes.start_measuring({'back_end': 'synthetic', 'rate': rate, **common},
                                      {'hand_eye_file': str(settings.hand_eye)}, separate)
                if robot:
                    nodes.start('bpc_sim.nodes.robot', **common)
                    nodes.start('bpc_sim.nodes.extruder', **common)
                yield RunningPrint(graph, nodes, start_ns, tick)
        finally:
            graph.close()
            del os.environ['ROS_DOMAIN_ID']
