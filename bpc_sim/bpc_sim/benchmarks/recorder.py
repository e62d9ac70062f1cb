"""Poses at 1000 Hz into the path recorder while full frames are captured and measured."""

from __future__ import annotations

import sys
import time

import numpy as np
from rclpy.publisher import Publisher

from bpc_interfaces.msg import DepositionPath
from bpc_perception.messages import topics
from bpc_perception.messages.path import path_from_message
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_sim.benchmarks.live import CAPTURE_RATE, FULL
from bpc_sim.benchmarks.printer import cpu_time, memory_mb, Printer, printing, START_DELAY
from bpc_sim.benchmarks.timing import clock, silent, Told
from bpc_sim.config import SimConfig
from bpc_sim.printer.messages import extruder_message, EXTRUDER_RATE, robot_message
from bpc_sim.printer.print_job import PrintJob

POSE_RATE = 1000  # [Hz]
BEFORE = 1.0  # of poses, before what is timed [s]


def run(seconds: float, progress: Told = silent) -> list[dict[str, object]]:
    """Verify that the path is the one that was driven; poses lost and share of a core."""
    speed = SimConfig(**FULL).job().length / seconds
    sim = {**FULL, 'speed': speed}
    job = SimConfig(**sim).job()
    tick = clock(progress, START_DELAY + seconds + BEFORE + 3)
    with printing(sim, CAPTURE_RATE, separate=True, robot=False, tick=tick) as printer:
        paths: list[DepositionPath] = []
        printer.peer.create_subscription(DepositionPath, topics.PATH, paths.append,
                                         topics.PATH_QOS)
        poses = printer.peer.create_publisher(
            topics.PRINT[topics.POSE], topics.POSE, topics.EXTRUSION_QOS)
        states = printer.peer.create_publisher(
            topics.PRINT[topics.EXTRUSION], topics.EXTRUSION, topics.EXTRUSION_QOS)
        printer.listen_until(printer.start_ns)
        pid = printer.nodes.pid('path_recorder')
        counted, used = send(job, printer, poses, states, seconds + BEFORE, pid)
        printer.listen_until(time.time_ns() + 3 * 10**9)
        verify(paths[-1], job)
        received = printer.count('path_recorder', 'poses')
        return [{
            'benchmark': 'recorder', 'pose_rate_hz': POSE_RATE, 'seconds': seconds,
            'capture_rate_hz': CAPTURE_RATE, 'poses_sent': counted, 'poses_received': received,
            'lost': counted - received, 'refused': printer.refusals('path_recorder'),
            'core_share': used / seconds,
            'captures_measured': printer.count('thickness', 'profiles'),
            'path_points': len(paths[-1].x), 'memory_end_mb': memory_mb(pid)}]


def send(job: PrintJob, printer: Printer, poses: Publisher, states: Publisher, seconds: float,
         pid: int) -> tuple[int, float]:
    """Send poses and states as time goes; how many poses, and time that the recorder took [s]."""
    times = np.arange(0, seconds, 1 / POSE_RATE)
    every = round(POSE_RATE / EXTRUDER_RATE)
    # Made before: making one takes longer than sending it.
    start_ns = printer.start_ns
    messages = [robot_message(job, t, start_ns + round(t * 1e9)) for t in times]
    extruder = [extruder_message(job, t, start_ns + round(t * 1e9)) for t in times[::every]]
    shift_ns = time.time_ns() - start_ns
    for message in (*messages, *extruder):
        stamp = message.header.stamp
        message.header.stamp = ns_to_stamp(stamp.sec * 10**9 + stamp.nanosec + shift_ns)
    begin, sent, used = time.monotonic(), 0, 0.0
    while sent < len(messages):
        due = min(int((time.monotonic() - begin) * POSE_RATE) + 1, len(messages))
        for number in range(sent, due):
            if number == round(BEFORE * POSE_RATE):
                used = cpu_time(pid)
            poses.publish(messages[number])
            if number % every == 0:
                states.publish(extruder[number // every])
        if sent // POSE_RATE < due // POSE_RATE:
            printer.tick()
        sent = due
        time.sleep(0.2 / POSE_RATE)
    return sent, cpu_time(pid) - used


def verify(message: DepositionPath, job: PrintJob) -> None:
    """Raise AssertionError unless the path lies where the nozzle was, without a hole."""
    path = path_from_message(message)
    assert path.arc_length[-1] > 0.95 * job.length
    np.testing.assert_allclose(path.points, job.tip(path.time + job.dwell_before), atol=1e-4)
    # Ten poses at most are averaged away at a corner; a missing tenth of a second would show.
    assert np.diff(path.arc_length).max() < 1e-3


if __name__ == '__main__':
    for row in run(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0):
        print(row)
