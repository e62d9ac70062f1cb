"""From the capture to the advice over real topics, and memory over many captures.

Full frames at 5 Hz, poses at 500 Hz. The latency counts from the moment at which the driver has
image and cloud of a capture in its hands until the advice has arrived in another process. The
stamp of the capture is 0.12 s earlier, as with a real camera. Late is advice that comes when the
next capture is due.
"""

from __future__ import annotations

from collections.abc import Callable
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
from bpc_sim.benchmarks.printer import memory_mb, Printer, printing, START_DELAY
from bpc_sim.benchmarks.timing import clock, silent, Told
from bpc_sim.config import SimConfig
from bpc_sim.printer.recording import CAMERA_LATENCY_NS

CAPTURE_RATE, POSE_RATE = 5.0, 500.0  # [Hz]
SMALL_RATE = 30.0  # of captures of 304 x 228 pixels, for memory [Hz]
WARM_UP = 4.0  # of the print, before what is timed [s]
# Of SimConfig.
SMALL: dict[str, Any] = {'scenario': 'archimedean', 'finished': True, 'pose_rate': POSE_RATE}
FULL = {**SMALL, 'full_size': True}


def run(seconds: float, progress: Told = silent) -> list[dict[str, object]]:
    """Verify, then time for this long each: composed, separate, memory."""
    verify()
    tick = clock(progress, 3 * (START_DELAY + WARM_UP + seconds))
    speed = SimConfig(**FULL).job().length / (seconds + WARM_UP)
    return [*(latency(seconds, speed, separate, tick) for separate in (False, True)),
            memory(seconds, speed, tick)]


def verify() -> None:
    """Raise AssertionError unless a capture handed over measures as one that was sent."""
    job = SimConfig(**{**FULL, 'speed': 0.02}).job()
    capture = job.capture(job.duration, 0, round(job.duration * 1e9))
    sent = capture_from_messages(*(
        deserialize_message(serialize_message(message), kind) for message, kind in zip(
            capture_to_messages(capture), (Image, CameraInfo, PointCloud2), strict=True)))
    s = np.arange(0, job.length, 2e-4)
    time = job.dwell_before + s / job.speed
    unknown = np.full(len(s), np.nan)
    path = DepositionPath('verify', 0, job.duration, True, time, s, job.tip(time), unknown,
                          unknown, job.extruding(time))
    first, second = (measure(each, path, job.view.T_base_camera, ThicknessConfig())
                     for each in (capture, sent))
    assert len(first) > 500
    for name in ('status', 'thickness', 'sigma', 'left_points', 'right_points'):
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes(), name


def latency(seconds: float, speed: float, separate: bool,
            tick: Callable[[], None]) -> dict[str, object]:
    """Capture to advice, in one process or across processes."""
    with printing({**FULL, 'speed': speed}, CAPTURE_RATE, separate, tick=tick) as printer:
        begin_ns = printer.start_ns + round(WARM_UP * 1e9)
        end_ns = begin_ns + round(seconds * 1e9)
        printer.listen_until(begin_ns)
        before, poses = resident(printer, separate), printer.count('path_recorder', 'poses')
        skipped = printer.count('thickness', SKIPPED)
        refused = printer.refusals('thickness')
        printer.listen_until(end_ns)
        poses = printer.count('path_recorder', 'poses') - poses
        printer.listen_until(end_ns + 10**9)
        timed = {stamp_to_ns(message.header.stamp): (arrived_ns, message)
                 for arrived_ns, message in printer.profiles}
        took, overhead, stamps = [], [], []
        for arrived_ns, advice in printer.advice:
            stamp_ns = stamp_to_ns(advice.header.stamp)
            if begin_ns < stamp_ns < end_ns:
                stamps.append(stamp_ns)
                took.append((arrived_ns - stamp_ns - CAMERA_LATENCY_NS) * 1e-6)
                overhead.append(took[-1] - timed[stamp_ns][1].processing_time * 1e3)
        period = 1e9 / CAPTURE_RATE
        # The driver takes a capture each period, so where two are missed the gap tells.
        lost = sum(round((later - earlier) / period) - 1 for earlier, later in pairwise(stamps))
        expected = round(seconds * CAPTURE_RATE)
        return {
            'benchmark': 'live', 'nodes': 'separate' if separate else 'composed',
            'width_pixels': 1944, 'height_pixels': 1200, 'capture_rate_hz': CAPTURE_RATE,
            'pose_rate_hz': poses / seconds, 'seconds': seconds, 'captures': len(stamps),
            'captures_expected': expected, 'lost': lost,
            'skipped': printer.count('thickness', SKIPPED) - skipped,
            'refused': printer.refusals('thickness') - refused,
            'late': sum(each > period * 1e-6 for each in took),
            'latency_median_ms': float(np.median(took)),
            'latency_p95_ms': float(np.percentile(took, 95)),
            'latency_maximum_ms': float(np.max(took)),
            'without_measurement_median_ms': float(np.median(overhead)),
            'without_measurement_p95_ms': float(np.percentile(overhead, 95)),
            'samples_last': len(printer.profiles[-1][1].thickness),
            'memory_begin_mb': before, 'memory_end_mb': resident(printer, separate)}


def memory(seconds: float, speed: float, tick: Callable[[], None]) -> dict[str, object]:
    """Memory of the composed process over many small captures."""
    with printing({**SMALL, 'speed': speed}, SMALL_RATE, separate=False, tick=tick) as printer:
        begin_ns = printer.start_ns + round(WARM_UP * 1e9)
        printer.listen_until(begin_ns + round(0.2 * seconds * 1e9))
        warm, captures = resident(printer, False), printer.count('camera_driver', 'captures')
        printer.listen_until(begin_ns + round(seconds * 1e9))
        captures = printer.count('camera_driver', 'captures') - captures
        end = resident(printer, False)
        return {
            'benchmark': 'live memory', 'nodes': 'composed', 'width_pixels': 304,
            'height_pixels': 228, 'capture_rate_hz': SMALL_RATE, 'seconds': seconds,
            'captures': captures, 'memory_warm_mb': warm, 'memory_end_mb': end,
            'growth_per_10000_captures_mb': (end - warm) / max(captures, 1) * 1e4,
            'recorder_memory_end_mb': memory_mb(printer.nodes.pid('path_recorder'))}


def resident(printer: Printer, separate: bool) -> float:
    """Memory of the processes of camera driver and thickness node [MB]."""
    names = ('thickness', 'camera_driver') if separate else ('composed',)
    return sum(memory_mb(printer.nodes.pid(name)) for name in names)


if __name__ == '__main__':
    for row in run(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0):
        print(row)
