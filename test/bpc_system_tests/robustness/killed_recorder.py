"""Recorders killed at random moments, and the poses and captures that they leave.

As a script, on full captures: ``python -m bpc_system_tests.robustness.killed_recorder --kills 100
--seed 1``.
"""

from __future__ import annotations

import argparse
from collections import Counter
from contextlib import ExitStack
from dataclasses import dataclass
import json
from pathlib import Path
import subprocess
import tempfile
from threading import Timer
import time

from geometry_msgs.msg import PoseStamped
import numpy as np
from rclpy.node import Node

from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.storage import mcap_file
from bpc_perception.runtime.isolated_graph import Graph
from bpc_perception.runtime.transport.dds_profiles import choose_profile
from bpc_system_tests.parts.command_line import PATIENCE_S, ROOT, running
from bpc_system_tests.parts.ros_graph import own_domain

READER = ROOT / 'test' / 'mcap_reader'
POSE_RATE_HZ, CAPTURE_PERIOD_S = 500, 0.5
KILL_TIMES_S = (0.2, 2.0)  # earliest and latest, after all record
MAX_POSES_LOST_S = 0.5
# A capture counts as finished this long after its last message was sent; a message may be under
# way for a tenth of a second, and longer on a busy machine.
UNDER_WAY_S = 0.5


@dataclass(frozen=True)
class Remains:
    """What is left of a recording.

    Attributes:
        bag: the folder.
        poses_lost: time from the last pose on disk to the kill [s].
        frames: captures that are complete on disk.
        frames_lost: captures that were finished before the kill but are not complete.
        holes: poses missing between those on disk, lost by best effort.
    """

    bag: Path
    poses_lost: float
    frames: int
    frames_lost: int
    holes: int


class NumberedPrinter:
    """Sends poses and captures whose stamps are their numbers."""

    def __init__(self, node: Node, width: int, height: int) -> None:
        self.poses_sent: list[float] = []  # monotonic time of each [s]
        self.frames_sent: list[float] = []
        self._poses = node.create_publisher(PoseStamped, topics.POSE, topics.EXTRUSION_QOS)
        self._camera = [node.create_publisher(kind, name, topics.CAMERA_QOS)
                        for name, kind in topics.CAMERA.items()]
        capture = Capture(
            0, 'camera', np.zeros((height, width, 3), np.uint8),
            np.ones((height, width, 3), np.float32),
            PinholeCamera(np.diag((1000.0, 1000.0, 1.0)), np.zeros(5), width, height))
        self._messages = capture_to_messages(capture)

    def send_pose(self) -> None:
        """Send the next pose."""
        message = PoseStamped()
        message.header.stamp.sec = len(self.poses_sent)
        self._poses.publish(message)
        self.poses_sent.append(time.monotonic())

    def send_frame(self) -> None:
        """Send the next capture."""
        for publisher, message in zip(self._camera, self._messages, strict=True):
            message.header.stamp.sec = len(self.frames_sent)
            publisher.publish(message)
        self.frames_sent.append(time.monotonic())

    def run(self, end: float) -> None:
        """Send at full rate until a monotonic time [s]."""
        begin, poses, frames = time.monotonic(), 0, 0
        while (now := time.monotonic()) < end:
            if now - begin >= frames * CAPTURE_PERIOD_S:
                frames += 1
                self.send_frame()
            elif now - begin >= poses / POSE_RATE_HZ:
                poses += 1
                self.send_pose()
            else:
                time.sleep(0.2 / POSE_RATE_HZ)


def kill_recorders(folder: Path, domain: int, moments: list[float], width: int,
                   height: int) -> list[Remains]:
    """Kill a recorder at each of these times [s] after all record; return what they leave."""
    bags = [folder / f'killed_{number}' for number in range(len(moments))]
    killed_at: dict[int, float] = {}
    graph = Graph(domain)
    try:
        printer = NumberedPrinter(graph.make(Node, 'printer'), width, height)
        with ExitStack() as stack:
            recorders = [stack.enter_context(running('record', '--out', bag)) for bag in bags]
            while not all(map(all_topics_recorded, bags)):
                assert all(recorder.poll() is None for recorder in recorders)
                printer.run(time.monotonic() + CAPTURE_PERIOD_S)
            first = len(printer.frames_sent)

            def kill(number: int) -> None:
                recorders[number].kill()
                killed_at[number] = time.monotonic()

            for number, moment in enumerate(moments):
                timer = Timer(moment, kill, (number,))
                stack.callback(timer.join)
                timer.start()
            printer.run(time.monotonic() + max(moments) + 0.1)
    finally:
        graph.close()
    return [find_remains(bag, printer, first, killed_at[number])
            for number, bag in enumerate(bags)]


def all_topics_recorded(bag: Path) -> bool:
    """Tell whether a recorder has recorded poses and captures."""
    try:
        found = {message.topic for file in Bag(bag).files for message in mcap_file.messages(file)}
    except ValueError:  # there is no file yet
        return False
    return found >= {f'/{name}' for name in (topics.POSE, *topics.CAMERA)}


def find_remains(bag: Path, printer: NumberedPrinter, first: int, killed_at: float) -> Remains:
    """Compare a bag with what was sent, from a capture number on."""
    numbers: dict[str, list[int]] = {f'/{name}': [] for name in (topics.POSE, *topics.CAMERA)}
    for topic, _, message in Bag(bag).messages(set(numbers)):
        numbers[topic].append(message.header.stamp.sec)
    poses = numbers.pop(f'/{topics.POSE}')
    frames = set.intersection(*map(set, numbers.values()))
    finished = {number for number, sent in enumerate(printer.frames_sent)
                if number >= first and sent < killed_at - UNDER_WAY_S}
    sent = [moment for moment in printer.poses_sent if moment < killed_at]
    return Remains(bag, sent[-1] - printer.poses_sent[poses[-1]], len(frames),
                   len(finished - frames), poses[-1] - poses[0] + 1 - len(poses))


def read_by_javascript(file: Path) -> dict[str, dict[str, int] | None]:
    """Count the messages of each topic with MCAP's own library for JavaScript."""
    ended = subprocess.run(['node', str(READER / 'read.js'), str(file)], capture_output=True,
                           text=True, timeout=PATIENCE_S, check=True)
    counts: dict[str, dict[str, int] | None] = json.loads(ended.stdout)
    return counts


def counts(bag: Path) -> dict[str, int]:
    """Count the messages of each topic with our reader."""
    return dict(Counter(message.topic for file in Bag(bag).files
                        for message in mcap_file.messages(file)))


def main() -> None:
    """Kill recorders; print a row for each kill, and the worst of all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--kills', type=int, default=100)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--at-once', type=int, default=2)
    parser.add_argument('--size', type=int, nargs=2, default=(1944, 1200))
    given = parser.parse_args()
    choose_profile(captures=True)
    rng, rows = np.random.default_rng(given.seed), []
    while len(rows) < given.kills:
        moments = rng.uniform(*KILL_TIMES_S, given.at_once).tolist()
        with tempfile.TemporaryDirectory() as folder, own_domain() as domain:
            for left in kill_recorders(Path(folder), domain, moments, *given.size):
                agree = read_by_javascript(Bag(left.bag).files[0])['stream'] == counts(left.bag)
                rows.append(left)
                print(f'{len(rows)}: poses lost {left.poses_lost:.3f} s, holes {left.holes}, '
                      f'frames {left.frames}, frames lost {left.frames_lost}, '
                      f'readers agree {agree}', flush=True)
                assert agree
    print(f'{len(rows)} kills, seed {given.seed}: poses lost at most '
          f'{max(row.poses_lost for row in rows):.3f} s, '
          f'median {np.median([row.poses_lost for row in rows]):.3f} s; '
          f'{sum(row.frames_lost for row in rows)} frames lost of '
          f'{sum(row.frames for row in rows)}; {sum(row.holes for row in rows)} holes')


if __name__ == '__main__':
    main()
