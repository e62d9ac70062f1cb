"""Prints at full rate for long, with faults of camera, robot and extruder, into running nodes.

As a script: ``python -m bpc_system_tests.robustness.soak --minutes 30 --seed 1``. The faults are
listed in the output with their times.
"""

from __future__ import annotations

import argparse
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
import sys
import tempfile
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from rclpy.node import Node
import yaml

from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.nodes.thickness import SKIPPED
from bpc_perception.runtime.child_processes import Nodes
from bpc_perception.runtime.isolated_graph import Graph
from bpc_perception.runtime.transport.dds_profiles import choose_profile
from bpc_sim.config import SimConfig
from bpc_sim.printer.messages import extruder_message, EXTRUDER_RATE_HZ, robot_message
from bpc_sim.printer.print_job import PrintJob
from bpc_system_tests.parts.ros_graph import own_domain
from bpc_system_tests.robustness.soak_faults import (
    CAMERA_FAULTS,
    EXTRUDER_FAULTS,
    POSE_FAULTS,
    spoiled,
    stamped,
)

NODES = ('path_recorder', 'thickness')
TARGET = 2e-3  # [m]
PAUSE = 3.0  # between prints, after which the recorder begins another [s]
PATIENCE = 1.0  # of the thickness node with a capture [s]
SETTLING = PATIENCE + 2.0  # until all that waits has been given up, and diagnostics say so [s]
# What the thickness node refuses that is no capture.
NO_CAPTURE = ('deposition_path',)


@dataclass(frozen=True)
class Load:
    """What is sent.

    Attributes:
        full_size: captures of 1944 x 1200 pixels, or else of their middle.
        capture_rate, pose_rate: [Hz].
        print_time: how long a print takes [s].
        camera_faults: share of captures that are spoiled.
        robot_faults, extruder_faults, silences: how often each [1/s].
        silence: how long camera, robot or extruder say nothing then [s].
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
    """What a node's process holds at a time [s].

    Memory is its own: of the shared memory of the middleware it maps ever more, up to all.
    """

    time: float
    memory_mb: float
    threads: int
    files: int


class Soak:
    """A printer with faults, and what the nodes make of it.

    Attributes:
        least, most: how many captures a receiver has to count, and how many it may: all of
            those that are sent twice or fall apart.
        poses_sent: how many.
        faults: how often each was injected.
        samples: of each node's process.
    """

    def __init__(self, graph: Graph, nodes: Nodes, load: Load, seed: int,
                 log: Callable[[str], None]) -> None:
        self._nodes, self._load, self._log = nodes, load, log
        self._graph = graph
        self._rng = np.random.default_rng(seed)
        self.node = graph.make(Node, 'soak')
        self._job = job(load)
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
        """What became of the captures: profiles, skipped, and refusals by kind."""
        counts = self._counts.get('thickness', {})
        found = {key.removeprefix('refused: '): count for key, count in counts.items()
                 if key.startswith('refused: ')}
        return {'profiles': counts.get('profiles', 0), 'skipped': counts.get(SKIPPED, 0),
                **{kind: count for kind, count in found.items() if kind not in NO_CAPTURE}}

    def refusals(self, node: str) -> int:
        """How much a node has refused."""
        return sum(count for key, count in self._counts[node].items()
                   if key.startswith('refused: '))

    def begin(self) -> None:
        """Wait until both nodes hear everything, with good captures."""
        heard = self.node.count_subscribers
        self._graph.spin_until(lambda: set(self._counts) == set(NODES) and all(
            heard(name) for name in (*topics.CAMERA, topics.POSE, topics.EXTRUSION)), 60.0)
        # Who is there has not always found us, too.
        good = replace(self._load, camera_faults=0.0, robot_faults=0.0, extruder_faults=0.0,
                       silences=0.0)
        while not sum(self.outcomes().values()):
            self.run(1 / good.capture_rate, good)
        self._spin(SETTLING)
        self._before = self.outcomes()
        self.least, self.most, self.poses_sent = 0, 0, 0

    def finish(self) -> dict[str, int]:
        """Wait until everything has had its outcome; the outcomes since ``begin``."""
        self._spin(SETTLING)
        return {kind: count - self._before.get(kind, 0)
                for kind, count in self.outcomes().items()}

    def run(self, seconds: float, load: Load | None = None) -> None:
        """Print for this long."""
        load = load or self._load
        begin = time.monotonic()
        next_pose = next_state = next_frame = next_look = begin
        next_silence = begin + self._rng.exponential(1 / load.silences) if load.silences else (
            begin + seconds)
        while (now := time.monotonic()) < begin + seconds:
            if now >= next_frame:
                next_frame += 1 / load.capture_rate
                self._send_frame(now, load)
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
                next_look = now + 1.0
                self._look(now - self._begin)
            else:
                self._spin(0.0)
                time.sleep(0.0005)

    def _spin(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while True:
            self._graph.executor.spin_once(timeout_sec=max(0.0, end - time.monotonic()))
            if time.monotonic() >= end:
                return

    def _look(self, now: float) -> None:
        self._nodes.check()
        for name in NODES:
            process = Path(f'/proc/{self._nodes.pid(name)}')
            self.samples[name].append(Sample(
                now, own_memory_mb(process), len(list(process.glob('task/*'))),
                len(list(process.glob('fd/*')))))
            if len(self.samples[name]) % 60 == 0:
                self._log(f'{now:.0f} s: {name} {self.samples[name][-1].memory_mb:.0f} MB')

    def _note(self, fault: str) -> None:
        self.faults[fault] += 1
        self._log(f'{time.monotonic() - self._begin:.3f} s: {fault}')

    def _job_time(self, now: float) -> float:
        return (now - self._begin) % (self._job.duration + PAUSE)

    def _send_frame(self, now: float, load: Load) -> None:
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
            self.least -= 1  # a receiver that is busy takes both for one
        else:
            fault = CAMERA_FAULTS[kind]
            self._publish(spoiled(self._good, fault, stamp), fault.most)

    def _publish(self, messages: dict[str, object], most: int) -> None:
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


def job(load: Load) -> PrintJob:
    """The print."""
    settings: dict[str, Any] = {'scenario': 'archimedean', 'full_size': load.full_size}
    length = SimConfig(**settings).job().length
    return SimConfig(**settings, speed=length / load.print_time).job()


@contextmanager
def soaking(load: Load, seed: int, log: Callable[[str], None]) -> Iterator[Soak]:
    """The nodes, running, and a printer that has begun."""
    printed = job(load)
    with tempfile.TemporaryDirectory() as folder, own_domain() as domain:
        calibration, settings = Path(folder, 'hand_eye.calib'), Path(folder, 'params.yaml')
        calibration.write_text(yaml.safe_dump(hand_eye_calibration(printed)))
        settings.write_text(yaml.safe_dump(node_parameters(printed, TARGET)))
        graph = Graph(domain)
        try:
            with Nodes(settings) as nodes:
                nodes.start('bpc_perception.nodes.path_recorder',
                            **{'path.auto_stop_after': PAUSE / 2})
                nodes.start('bpc_perception.nodes.thickness', hand_eye_file=str(calibration),
                            patience=PATIENCE)
                soak = Soak(graph, nodes, load, seed, log)
                soak.begin()
                yield soak
        finally:
            graph.close()


def own_memory_mb(process: Path) -> float:
    """Resident memory of a process in /proc that it shares with none [MB]."""
    status = dict(line.split(':', 1) for line in (process / 'status').read_text().splitlines())
    return float(status['RssAnon'].split()[0]) * 1024e-6


def growth(samples: list[Sample], quantity: str) -> tuple[float, float]:
    """Median of a quantity in the second quarter of the run, and in the last."""
    values = np.array([getattr(sample, quantity) for sample in samples])
    quarter = len(values) // 4
    return float(np.median(values[quarter:2 * quarter])), float(np.median(values[-quarter:]))


def main() -> None:
    """Soak, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--minutes', type=float, default=30.0)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--small', action='store_true', help='small captures, four times as many')
    given = parser.parse_args()
    choose_profile(captures=True)
    load = Load(full_size=False, capture_rate=10.0) if given.small else Load()
    with soaking(load, given.seed, lambda line: print(line, flush=True)) as soak:
        soak.run(given.minutes * 60)
        outcomes = soak.finish()
        print(f'seed {given.seed}, {given.minutes:g} minutes; faults: {dict(soak.faults)}')
        total = sum(outcomes.values())
        print(f'captures: {soak.least} to {soak.most}; outcomes {total}: {outcomes}')
        print(f'poses sent: {soak.poses_sent}')
        for name, samples in soak.samples.items():
            for quantity in ('memory_mb', 'threads', 'files'):
                print(name, quantity, *growth(samples, quantity))
        sys.exit(0 if soak.least <= total <= soak.most else 1)


if __name__ == '__main__':
    main()
