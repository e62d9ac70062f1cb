"""A printer that prints at full rate, with faults, into running nodes."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from rclpy.node import Node

from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.nodes.thickness import BEFORE_PRINT, SKIPPED
from bpc_perception.runtime.child_processes import Nodes
from bpc_perception.runtime.isolated_graph import Graph
from bpc_sim.config import SimConfig
from bpc_sim.printer.messages import extruder_message, EXTRUDER_RATE_HZ, robot_message
from bpc_sim.printer.print_job import PrintJob
from bpc_system_tests.robustness.soak_faults import (
    CAMERA_FAULTS,
    EXTRUDER_FAULTS,
    POSE_FAULTS,
    spoiled,
    stamped,
)

NODES = ('path_recorder', 'thickness')
PRINT_PAUSE_S = 3.0  # between prints, so that the recorder begins another
CAPTURE_PATIENCE_S = 1.0  # of the thickness node with a capture
# Until all that waits has been given up, and diagnostics report it.
SETTLING_S = CAPTURE_PATIENCE_S + 2.0
START_PATIENCE_S = 60.0
LOOK_PERIOD_S = 1.0  # between two samples of the processes
IDLE_S = 0.0005  # when nothing is due
OTHER_REFUSALS = ('deposition_path',)  # of the thickness node, which are no captures


@dataclass(frozen=True)
class Load:
    """What is sent.

    Attributes:
        full_size: captures of 1944 x 1200 pixels; otherwise of their middle only.
        capture_rate, pose_rate: rates [Hz].
        print_time: how long a print takes [s].
        camera_faults: share of captures that are spoiled.
        robot_faults, extruder_faults, silences: mean rates of faults [1/s].
        silence: how long camera, robot or extruder are silent then [s].
    """

    full_size: bool = True
    capture_rate: float = 2.5
    pose_rate: float = 500.0
    print_time: float = 60.0
    camera_faults: float = 0.4
    robot_faults: float = 0.5
    extruder_faults: float = 0.2
    silences: float = 0.05
    silence: float = 2.0


@dataclass(frozen=True)
class Sample:
    """The resources of a node's process at a time [s].

    Memory is that of the process alone: of the middleware's shared memory it maps more and more,
    up to all.
    """

    time: float
    memory_mb: float
    threads: int
    files: int


class SoakPrinter:
    """A printer with faults, and what the nodes make of its messages.

    Attributes:
        least, most: how many captures a receiver must count, and how many it may count: a capture
            may be sent twice, or its messages may be taken for two captures.
        poses_sent: number of poses.
        faults: how often each fault was injected.
        samples: resources of each node's process.
    """

    def __init__(self, graph: Graph, nodes: Nodes, load: Load, seed: int,
                 log: Callable[[str], None]) -> None:
        self._nodes, self._load, self._log = nodes, load, log
        self._graph = graph
        self._rng = np.random.default_rng(seed)
        self.node = graph.make(Node, 'soak')
        self._job = make_job(load)
        capture = self._job.capture(self._job.duration, 0, 0)
        self._good = dict(zip(topics.CAMERA, capture_to_messages(capture), strict=True))
        self._camera = {name: self.node.create_publisher(kind, name, topics.CAMERA_QOS)
                        for name, kind in topics.CAMERA.items()}
        self._poses = self.node.create_publisher(
            topics.PRINT[topics.POSE], topics.POSE, topics.EXTRUSION_QOS)
        self._states = self.node.create_publisher(
            topics.PRINT[topics.EXTRUSION], topics.EXTRUSION, topics.EXTRUSION_QOS)
        self._counts: dict[str, dict[str, int]] = {}
        self.node.create_subscription(DiagnosticArray, '/diagnostics', self._hear, 100)
        self.least, self.most, self.poses_sent = 0, 0, 0
        self.faults: Counter[str] = Counter()
        self.samples: dict[str, list[Sample]] = defaultdict(list)
        self._begin = time.monotonic()
        self._silent = dict.fromkeys(('camera', 'robot', 'extruder'), 0.0)

    def _hear(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name in NODES:
                self._counts[status.name] = {
                    value.key: int(value.value) for value in status.values
                    if value.value.isdecimal()}

    def outcomes(self) -> dict[str, int]:
        """Return what became of the captures: profiles, skipped ones, and refusals by kind."""
        counts = self._counts.get('thickness', {})
        found = {key.removeprefix('refused: '): count for key, count in counts.items()
                 if key.startswith('refused: ')}
        return {'profiles': counts.get('profiles', 0), 'skipped': counts.get(SKIPPED, 0),
                'before a print': counts.get(BEFORE_PRINT, 0),
                **{kind: count for kind, count in found.items() if kind not in OTHER_REFUSALS}}

    def refusals(self, node: str) -> int:
        """Return how much a node has refused."""
        return sum(count for key, count in self._counts[node].items()
                   if key.startswith('refused: '))

    def begin(self) -> None:
        """Wait until both nodes hear everything, and then send good captures."""
        names = *topics.CAMERA, topics.POSE, topics.EXTRUSION
        self._graph.spin_until(
            lambda: set(self._counts) == set(NODES)
            and all(self.node.count_subscribers(name) for name in names), START_PATIENCE_S)
        # A node that we see may not have discovered us yet.
        good = replace(self._load, camera_faults=0.0, robot_faults=0.0, extruder_faults=0.0,
                       silences=0.0)
        while not sum(self.outcomes().values()):
            self.run(1 / good.capture_rate, good)
        self._spin(SETTLING_S)
        self._before = self.outcomes()
        self.least, self.most, self.poses_sent = 0, 0, 0

    def finish(self) -> dict[str, int]:
        """Wait until every capture has its outcome; return the outcomes since ``begin``."""
        self._spin(SETTLING_S)
        return {kind: count - self._before.get(kind, 0)
                for kind, count in self.outcomes().items()}

    def run(self, seconds: float, load: Load | None = None) -> None:
        """Print for a time [s]."""
        load = load or self._load
        begin = time.monotonic()
        next_pose = next_state = next_capture = next_look = begin
        next_silence = begin + self._rng.exponential(1 / load.silences) if load.silences else (
            begin + seconds)
        while (now := time.monotonic()) < begin + seconds:
            if now >= next_capture:
                next_capture += 1 / load.capture_rate
                self._send_capture(now, load)
            elif now >= next_silence:
                next_silence = now + self._rng.exponential(1 / load.silences)
                who = str(self._rng.choice(list(self._silent)))
                self._silent[who] = now + load.silence
                self._note(f'{who} silent')
            elif now >= next_state:
                next_state += 1 / EXTRUDER_RATE_HZ
                self._send_state(now, load)
            elif now >= next_pose:
                next_pose += 1 / load.pose_rate
                self._send_pose(now, load)
            elif now >= next_look:
                next_look = now + LOOK_PERIOD_S
                self._look(now - self._begin)
            else:
                self._spin(0.0)
                time.sleep(IDLE_S)

    def _spin(self, seconds: float) -> None:
        """Listen for a time [s], at least once."""
        end = time.monotonic() + seconds
        while True:
            self._graph.executor.spin_once(timeout_sec=max(0.0, end - time.monotonic()))
            if time.monotonic() >= end:
                return

    def _look(self, now: float) -> None:
        """Take a sample of each node's process at a time [s]."""
        self._nodes.check()
        for name in NODES:
            process = Path(f'/proc/{self._nodes.pid(name)}')
            self.samples[name].append(Sample(
                now, own_memory_mb(process), len(list(process.glob('task/*'))),
                len(list(process.glob('fd/*')))))
            if len(self.samples[name]) % 60 == 0:
                self._log(f'{now:.0f} s: {name} {self.samples[name][-1].memory_mb:.0f} MB')

    def _note(self, fault: str) -> None:
        """Count and log a fault."""
        self.faults[fault] += 1
        self._log(f'{time.monotonic() - self._begin:.3f} s: {fault}')

    def _job_time(self, now: float) -> float:
        """Return the time of the job [s]; prints follow one another."""
        return (now - self._begin) % (self._job.duration + PRINT_PAUSE_S)

    def _send_capture(self, now: float, load: Load) -> None:
        if now < self._silent['camera']:
            return
        stamp = ns_to_stamp(time.time_ns())
        if self._rng.random() >= load.camera_faults:
            self._publish(stamped(self._good, stamp), 1)
            return
        kind = str(self._rng.choice([*CAMERA_FAULTS, 'twice']))
        self._note(f'camera: {kind}')
        if kind == 'twice':
            for _ in range(2):
                self._publish(stamped(self._good, stamp), 1)
            self.least -= 1  # a busy receiver may count both as one
        else:
            fault = CAMERA_FAULTS[kind]
            self._publish(spoiled(self._good, fault, stamp), fault.most)

    def _publish(self, messages: dict[str, object], most: int) -> None:
        """Publish the messages of a capture in random order; a receiver counts 1 to ``most``."""
        self.least += 1
        self.most += most
        for name in self._rng.permutation(list(messages)):
            self._camera[name].publish(messages[name])

    def _send_pose(self, now: float, load: Load) -> None:
        if now < self._silent['robot']:
            return
        message = robot_message(self._job, self._job_time(now), time.time_ns())
        if self._rng.random() < load.robot_faults / load.pose_rate:
            kind = str(self._rng.choice([*POSE_FAULTS, 'twice']))
            self._note(f'robot: {kind}')
            if kind == 'twice':
                self._poses.publish(message)
                self.poses_sent += 1
            else:
                POSE_FAULTS[kind](message)
        self._poses.publish(message)
        self.poses_sent += 1

    def _send_state(self, now: float, load: Load) -> None:
        if now < self._silent['extruder']:
            return
        message = extruder_message(self._job, self._job_time(now), time.time_ns())
        if self._rng.random() < load.extruder_faults / EXTRUDER_RATE_HZ:
            kind = str(self._rng.choice(list(EXTRUDER_FAULTS)))
            self._note(f'extruder: {kind}')
            EXTRUDER_FAULTS[kind](message)
        self._states.publish(message)


def make_job(load: Load) -> PrintJob:
    """Return the print."""
    settings: dict[str, Any] = {'scenario': 'archimedean', 'full_size': load.full_size}
    length = SimConfig(**settings).job().length
    return SimConfig(**settings, speed=length / load.print_time).job()


def own_memory_mb(process: Path) -> float:
    """Return the resident memory of a process in /proc that it does not share [MB]."""
    status = dict(line.split(':', 1) for line in (process / 'status').read_text().splitlines())
    return float(status['RssAnon'].split()[0]) * 1024e-6
