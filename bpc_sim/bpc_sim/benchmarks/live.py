"""From the capture to the advice over real topics, and memory over many captures.

Full frames at 5 Hz, poses at 500 Hz. The latency counts from the moment when the driver has image
and cloud of a capture until the advice has arrived in another process. The stamp of the capture is
0.12 s earlier, as with a real camera. Advice is late if it comes when the next capture is due.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
import sys
from typing import Any

import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CameraInfo, Image, PointCloud2

from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.messages.capture import capture_from_messages, capture_to_messages
from bpc_perception.messages.stamps import stamp_to_ns
from bpc_perception.nodes.thickness import SKIPPED
from bpc_sim.benchmarks.process_usage import memory_mb
from bpc_sim.benchmarks.running_print import running_print, RunningPrint, START_DELAY_S
from bpc_sim.benchmarks.timing import no_progress, Progress, progress_clock
from bpc_sim.config import SimConfig
from bpc_sim.printer.messages import CAMERA_LATENCY_NS

CAPTURE_RATE_HZ, POSE_RATE_HZ = 5.0, 500.0
SMALL_CAPTURE_RATE_HZ = 30.0  # of captures of 304 x 228 pixels, for memory
WARM_UP_S = 4.0  # of the print, before anything is timed
# Values of SimConfig.
SMALL: dict[str, Any] = {'scenario': 'archimedean', 'finished': True, 'pose_rate': POSE_RATE_HZ}
FULL = {**SMALL, 'full_size': True}


@dataclass(frozen=True)
class Latencies:
    """Latencies of N captures.

    Attributes:
        stamps_ns: stamps of the captures.
        total_ms: from the capture to the advice.
        overhead_ms: the same without the measurement.
    """

    stamps_ns: list[int]
    total_ms: list[float]
    overhead_ms: list[float]

    def lost(self, period_ns: float) -> int:
        """Return how many captures are missing between these, at one per period [ns]."""
        return sum(round((later - earlier) / period_ns) - 1
                   for earlier, later in pairwise(self.stamps_ns))


def run(seconds: float, progress: Progress = no_progress) -> list[dict[str, object]]:
    """Verify, then time composed nodes, separate nodes and memory, each for this long [s]."""
    verify()
    tick = progress_clock(progress, 3 * (START_DELAY_S + WARM_UP_S + seconds))
    speed = SimConfig(**FULL).job().length / (seconds + WARM_UP_S)
    return [*(time_latency(seconds, speed, separate, tick) for separate in (False, True)),
            watch_memory(seconds, speed, tick)]


def verify() -> None:
    """Raise AssertionError unless a capture in memory measures the same as one sent."""
    job = SimConfig(**{**FULL, 'speed': 0.02}).job()
    capture = job.capture(job.duration, 0, round(job.duration * 1e9))
    sent = capture_from_messages(*(
        deserialize_message(serialize_message(message), kind) for message, kind in zip(
            capture_to_messages(capture), (Image, CameraInfo, PointCloud2), strict=True)))
    s = np.arange(0, job.length, 2e-4)
    time = job.dwell_before + s / job.speed
    unknown = np.full(len(s), np.nan)
    path = DepositionPath('verify', 0, job.duration, True, time, s, job.tip(time), unknown,
                          unknown, job.extruding(time), np.ones(len(s), bool))
    first, second = (measure(each, path, job.view.T_base_camera, ThicknessConfig())
                     for each in (capture, sent))
    assert len(first) > 500
    for name in ('status', 'thickness', 'sigma', 'left_points', 'right_points'):
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes(), name


def time_latency(seconds: float, speed: float, separate: bool,
                 tick: Callable[[], None]) -> dict[str, object]:
    """Time capture to advice for a while [s], in one process or across processes."""
    with running_print({**FULL, 'speed': speed}, CAPTURE_RATE_HZ, separate, tick=tick) as running:
        begin_ns = running.start_ns + round(WARM_UP_S * 1e9)
        end_ns = begin_ns + round(seconds * 1e9)
        running.listen_until(begin_ns)
        memory, poses = resident_mb(running, separate), running.count('path_recorder', 'poses')
        skipped, refused = running.count('thickness', SKIPPED), running.refusals('thickness')
        running.listen_until(end_ns)
        poses = running.count('path_recorder', 'poses') - poses
        running.listen_until(end_ns + 10**9)
        found = find_latencies(running, begin_ns, end_ns)
        period_ns = 1e9 / CAPTURE_RATE_HZ
        return {
            'benchmark': 'live', 'nodes': 'separate' if separate else 'composed',
            'width_pixels': 1944, 'height_pixels': 1200, 'capture_rate_hz': CAPTURE_RATE_HZ,
            'pose_rate_hz': poses / seconds, 'seconds': seconds,
            'captures': len(found.stamps_ns),
            'captures_expected': round(seconds * CAPTURE_RATE_HZ),
            # The driver takes a capture each period: a longer gap between stamps is a loss.
            'lost': found.lost(period_ns),
            'skipped': running.count('thickness', SKIPPED) - skipped,
            'refused': running.refusals('thickness') - refused,
            'late': sum(each > period_ns * 1e-6 for each in found.total_ms),
            'latency_median_ms': float(np.median(found.total_ms)),
            'latency_p95_ms': float(np.percentile(found.total_ms, 95)),
            'latency_maximum_ms': float(np.max(found.total_ms)),
            'without_measurement_median_ms': float(np.median(found.overhead_ms)),
            'without_measurement_p95_ms': float(np.percentile(found.overhead_ms, 95)),
            'samples_last': len(running.profiles[-1].message.thickness),
            'memory_begin_mb': memory, 'memory_end_mb': resident_mb(running, separate)}


def find_latencies(running: RunningPrint, begin_ns: int, end_ns: int) -> Latencies:
    """Return the latencies of the captures that were stamped between two times [ns]."""
    profiles = {stamp_to_ns(arrival.message.header.stamp): arrival.message
                for arrival in running.profiles}
    found = Latencies([], [], [])
    for arrival in running.advice:
        stamp_ns = stamp_to_ns(arrival.message.header.stamp)
        if begin_ns < stamp_ns < end_ns:
            total_ms = (arrival.time_ns - stamp_ns - CAMERA_LATENCY_NS) * 1e-6
            found.stamps_ns.append(stamp_ns)
            found.total_ms.append(total_ms)
            found.overhead_ms.append(total_ms - profiles[stamp_ns].processing_time * 1e3)
    return found


def watch_memory(seconds: float, speed: float, tick: Callable[[], None]) -> dict[str, object]:
    """Watch the memory of the composed process over many small captures."""
    with running_print({**SMALL, 'speed': speed}, SMALL_CAPTURE_RATE_HZ, separate=False,
                       tick=tick) as running:
        begin_ns = running.start_ns + round(WARM_UP_S * 1e9)
        running.listen_until(begin_ns + round(0.2 * seconds * 1e9))
        warm, captures = resident_mb(running, False), running.count('camera_driver', 'captures')
        running.listen_until(begin_ns + round(seconds * 1e9))
        captures = running.count('camera_driver', 'captures') - captures
        end = resident_mb(running, False)
        return {
            'benchmark': 'live memory', 'nodes': 'composed', 'width_pixels': 304,
            'height_pixels': 228, 'capture_rate_hz': SMALL_CAPTURE_RATE_HZ, 'seconds': seconds,
            'captures': captures, 'memory_warm_mb': warm, 'memory_end_mb': end,
            'growth_per_10000_captures_mb': (end - warm) / max(captures, 1) * 1e4,
            'recorder_memory_end_mb': memory_mb(running.nodes.pid('path_recorder'))}


def resident_mb(running: RunningPrint, separate: bool) -> float:
    """Return the memory of the processes of camera driver and thickness node [MB]."""
    names = ('thickness', 'camera_driver') if separate else ('composed',)
    return sum(memory_mb(running.nodes.pid(name)) for name in names)


if __name__ == '__main__':
    for row in run(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0):
        print(row)
