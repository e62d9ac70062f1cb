"""Poses at 1000 Hz into the path recorder while full frames are captured and measured."""

from __future__ import annotations

from dataclasses import dataclass
import sys
import time
from typing import Any

import numpy as np

from bpc_interfaces.msg import DepositionPath
from bpc_perception.messages import topics
from bpc_perception.messages.path import path_from_message
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_sim.benchmarks.live import CAPTURE_RATE_HZ, FULL
from bpc_sim.benchmarks.process_usage import cpu_time, memory_mb
from bpc_sim.benchmarks.running_print import running_print, RunningPrint, START_DELAY_S
from bpc_sim.benchmarks.timing import no_progress, Progress, progress_clock
from bpc_sim.config import SimConfig
from bpc_sim.printer.messages import extruder_message, EXTRUDER_RATE_HZ, robot_message
from bpc_sim.printer.print_job import PrintJob

POSE_RATE_HZ = 1000
WARM_UP_S = 1.0  # of poses, before anything is timed
SETTLING_S = 3  # after the last pose
POSES_PER_STATE = round(POSE_RATE_HZ / EXTRUDER_RATE_HZ)


@dataclass(frozen=True)
class Sent:
    """What was sent to the recorder.

    Attributes:
        poses: how many poses.
        cpu_time: processor time of the recorder after the warm-up [s].
    """

    poses: int
    cpu_time: float


def run(seconds: float, progress: Progress = no_progress) -> list[dict[str, object]]:
    """Verify the recorded path; count lost poses and the recorder's share of a core."""
    sim = {**FULL, 'speed': SimConfig(**FULL).job().length / seconds}
    job = SimConfig(**sim).job()
    tick = progress_clock(progress, START_DELAY_S + seconds + WARM_UP_S + SETTLING_S)
    with running_print(sim, CAPTURE_RATE_HZ, separate=True, robot=False, tick=tick) as running:
        paths: list[DepositionPath] = []
        running.peer.create_subscription(DepositionPath, topics.PATH, paths.append,
                                         topics.PATH_QOS)
        publishers = {name: running.peer.create_publisher(topics.PRINT[name], name,
                                                          topics.EXTRUSION_QOS)
                      for name in (topics.POSE, topics.EXTRUSION)}
        running.listen_until(running.start_ns)
        pid = running.nodes.pid('path_recorder')
        sent = send(job, running, publishers, seconds + WARM_UP_S, pid)
        running.listen_until(time.time_ns() + SETTLING_S * 10**9)
        verify(paths[-1], job)
        received = running.count('path_recorder', 'poses')
        return [{
            'benchmark': 'recorder', 'pose_rate_hz': POSE_RATE_HZ, 'seconds': seconds,
            'capture_rate_hz': CAPTURE_RATE_HZ, 'poses_sent': sent.poses,
            'poses_received': received, 'lost': sent.poses - received,
            'refused': running.refusals('path_recorder'), 'core_share': sent.cpu_time / seconds,
            'captures_measured': running.count('thickness', 'profiles'),
            'path_points': len(paths[-1].x), 'memory_end_mb': memory_mb(pid)}]


def send(job: PrintJob, running: RunningPrint, publishers: dict[str, Any], seconds: float,
         pid: int) -> Sent:
    """Send poses and states in real time for a while [s], and time the recorder of this pid."""
    # Made in advance: making a message takes longer than sending it.
    poses, states = make_messages(job, running.start_ns, seconds)
    begin, sent, used = time.monotonic(), 0, 0.0
    while sent < len(poses):
        due = min(int((time.monotonic() - begin) * POSE_RATE_HZ) + 1, len(poses))
        for number in range(sent, due):
            if number == round(WARM_UP_S * POSE_RATE_HZ):
                used = cpu_time(pid)
            publishers[topics.POSE].publish(poses[number])
            if number % POSES_PER_STATE == 0:
                publishers[topics.EXTRUSION].publish(states[number // POSES_PER_STATE])
        if sent // POSE_RATE_HZ < due // POSE_RATE_HZ:
            running.tick()
        sent = due
        time.sleep(0.2 / POSE_RATE_HZ)
    return Sent(sent, cpu_time(pid) - used)


def make_messages(job: PrintJob, start_ns: int, seconds: float) -> tuple[list[Any], list[Any]]:
    """Return poses and extruder states of a print, stamped as if it started now."""
    times = np.arange(0, seconds, 1 / POSE_RATE_HZ)
    poses = [robot_message(job, t, start_ns + round(t * 1e9)) for t in times]
    states = [extruder_message(job, t, start_ns + round(t * 1e9))
              for t in times[::POSES_PER_STATE]]
    shift_ns = time.time_ns() - start_ns
    for message in (*poses, *states):
        stamp = message.header.stamp
        message.header.stamp = ns_to_stamp(stamp.sec * 10**9 + stamp.nanosec + shift_ns)
    return poses, states


def verify(message: DepositionPath, job: PrintJob) -> None:
    """Raise AssertionError unless the path lies where the nozzle was, without a hole."""
    path = path_from_message(message)
    assert path.arc_length[-1] > 0.95 * job.length
    np.testing.assert_allclose(path.points, job.tip(path.time + job.dwell_before), atol=1e-4)
    # At a corner up to ten poses are averaged away; a missing tenth of a second would show.
    assert np.diff(path.arc_length).max() < 1e-3


if __name__ == '__main__':
    for row in run(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0):
        print(row)
