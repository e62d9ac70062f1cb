"""Recordings of simulated prints, made without a graph: the same seed gives the same bag."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.recording.bag_writer import BagWriter
from bpc_sim.printer.messages import (
    CAMERA_LATENCY_NS,
    extruder_message,
    EXTRUDER_RATE_HZ,
    robot_message,
)
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import POSE_RATE_HZ
from bpc_sim.printer.settings import write_settings

START_NS = 1_790_000_000_000_000_000  # an arbitrary but fixed date
OVERTIME_S = 0.5  # how long robot and extruder go on after the job's end


def record_print(job: PrintJob, folder: str | Path, capture_period: float, target: float,
                 progress: Callable[[int, int], None] | None = None, prints: int = 1,
                 pause: float = 30.0, first_ns: int = START_NS) -> None:
    """Write a print to a new bag, with its calibration and parameters beside the recording.

    Args:
        job: the print.
        folder: the new bag.
        capture_period: time from capture to capture [s]; there is one at the job's end, too.
        target: wanted thickness [m].
        progress: called with the number of captures done and of all captures.
        prints: how often the job is printed, each time on a new bed.
        pause: between these, in which nothing is sent [s].
        first_ns: when the first one starts [ns].
    """
    times = [*np.arange(capture_period, job.duration - capture_period / 2, capture_period),
             job.duration]
    with BagWriter(folder, compress=True) as bag:
        for name, kind in (topics.PRINT | topics.CAMERA).items():
            bag.add_topic(f'/{name}', topics.type_name(kind))
        for repeat in range(prints):
            start_ns = first_ns + round(1e9 * repeat * (job.duration + pause))
            for delay_ns, name, t in _events(job, times):
                log_ns, stamp_ns = start_ns + delay_ns, start_ns + round(1e9 * t)
                if name == topics.POSE:
                    bag.write(f'/{name}', log_ns, robot_message(job, t, stamp_ns))
                elif name == topics.EXTRUSION:
                    bag.write(f'/{name}', log_ns, extruder_message(job, t, stamp_ns))
                else:
                    number = times.index(t)
                    _write_capture(bag, log_ns, job, t, number, stamp_ns)
                    if progress is not None:
                        progress(repeat * len(times) + number + 1, prints * len(times))
    write_settings(job, target, Path(folder))


def _events(job: PrintJob, capture_times: list[float]) -> list[tuple[int, str, float]]:
    """Return what is logged when: time after the job's start [ns], topic and time [s], in order.

    The topic of the image stands for a whole capture.
    """
    poses = np.arange(0, job.duration + OVERTIME_S, 1 / POSE_RATE_HZ)
    states = np.arange(0, job.duration + OVERTIME_S, 1 / EXTRUDER_RATE_HZ)
    events = [(round(1e9 * t), topics.POSE, t) for t in poses]
    events += [(round(1e9 * t), topics.EXTRUSION, t) for t in states]
    events += [(round(1e9 * t) + CAMERA_LATENCY_NS, topics.IMAGE, t)
               for t in capture_times]
    return sorted(events)


def _write_capture(bag: BagWriter, log_ns: int, job: PrintJob, t: float, number: int,
                   stamp_ns: int) -> None:
    """Write the messages of the capture of a number, taken at time t [s] of the job."""
    messages = capture_to_messages(job.capture(t, number, stamp_ns))
    for topic, message in zip(topics.CAMERA, messages, strict=True):
        bag.write(f'/{topic}', log_ns, message)
