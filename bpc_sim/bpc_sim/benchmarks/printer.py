"""A synthetic printer and the nodes that measure it, as processes of a graph of their own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
import os
from pathlib import Path
import tempfile
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
import yaml

from bpc_interfaces.msg import RateAdvice, ThicknessProfile
from bpc_perception.messages import topics
from bpc_perception.runtime.child_processes import Nodes
from bpc_perception.runtime.isolated_graph import free_domain, Graph
from bpc_sim.config import SimConfig
from bpc_sim.printer.recording import hand_eye, parameters

TARGET = 2e-3  # [m]
START_DELAY = 12.0  # in which all nodes start and a full capture is rendered [s]


class Printer:
    """The running nodes, and what they say.

    Attributes:
        nodes: the processes.
        tick: called again and again while time passes.
        graph: of the benchmark's own node, ``peer``.
        start_ns: when the print starts.
        advice, profiles: (time of arrival [ns], message), in order.
    """

    def __init__(self, graph: Graph, nodes: Nodes, start_ns: int,
                 tick: Callable[[], None]) -> None:
        self.graph, self.nodes, self.start_ns, self.tick = graph, nodes, start_ns, tick
        self.peer: Node = graph.make(Node, 'benchmark')
        self.advice: list[tuple[int, RateAdvice]] = []
        self.profiles: list[tuple[int, ThicknessProfile]] = []
        self._counts: dict[str, dict[str, int]] = {}
        for kind, name, heard in ((RateAdvice, topics.ADVICE, self.advice),
                                  (ThicknessProfile, topics.PROFILE, self.profiles)):
            self.peer.create_subscription(kind, name, partial(_note, heard), topics.RESULT_QOS)
        self.peer.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 100)

    def count(self, node: str, event: str) -> int:
        """The latest count of an event or refusal in a node's diagnostics."""
        return self._counts.get(node, {}).get(event, 0)

    def refusals(self, node: str) -> int:
        """How much a node has refused by now."""
        return sum(count for event, count in self._counts.get(node, {}).items()
                   if event.startswith('refused'))

    def listen_until(self, time_ns: int) -> None:
        """Listen until this time; raises NodeError when a node ends before."""
        while time.time_ns() < time_ns:
            self.nodes.check()
            self.graph.executor.spin_once(timeout_sec=0.05)
            self.tick()

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._counts[status.name] = {value.key: int(value.value) for value in status.values
                                         if value.value.isdecimal()}


def _note(heard: list[tuple[int, Any]], message: Any) -> None:
    heard.append((time.time_ns(), message))


@contextmanager
def printing(sim: dict[str, Any], rate: float, separate: bool,
             robot: bool = True, tick: Callable[[], None] = lambda: None) -> Iterator[Printer]:
    """A print that starts ``START_DELAY`` from now, captured at a rate [Hz].

    ``sim`` has the values of SimConfig but the start; without ``robot`` the caller sends its poses
    and the extruder's states.
    """
    start_ns = time.time_ns() + round(START_DELAY * 1e9)
    job = SimConfig(**sim).job()
    common = {**sim, 'start_time_ns': start_ns}
    with free_domain() as domain, tempfile.TemporaryDirectory() as folder:
        calibration, settings = Path(folder, 'hand_eye.calib'), Path(folder, 'params.yaml')
        calibration.write_text(yaml.safe_dump(hand_eye(job)))
        settings.write_text(yaml.safe_dump(parameters(job, TARGET)))
        os.environ['ROS_DOMAIN_ID'] = str(domain)
        graph = Graph(domain)
        try:
            with Nodes(settings) as nodes:
                nodes.start('bpc_perception.nodes.path_recorder')
                nodes.start_measuring({'back_end': 'synthetic', 'rate': rate, **common},
                                      {'hand_eye_file': str(calibration)}, separate)
                if robot:
                    nodes.start('bpc_sim.nodes.robot', **common)
                    nodes.start('bpc_sim.nodes.extruder', **common)
                yield Printer(graph, nodes, start_ns, tick)
        finally:
            graph.close()
            del os.environ['ROS_DOMAIN_ID']


def memory_mb(process: int) -> float:
    """Resident memory of a process [MB]."""
    pages = int(Path(f'/proc/{process}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 1e6


def cpu_time(process: int) -> float:
    """Time of all cores that a process has taken so far [s]."""
    # Fields 14 and 15 of proc(5); the second, in parentheses, may hold spaces.
    fields = Path(f'/proc/{process}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')
