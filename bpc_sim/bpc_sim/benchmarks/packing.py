"""How much room packed captures take, and how long it takes to pack and to unpack them."""

from __future__ import annotations

from functools import partial

import numpy as np
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CameraInfo

from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.recording.capture_packing import packed
from bpc_perception.recording.storage.packing import unpacked
from bpc_sim.benchmarks.live import FULL, SMALL
from bpc_sim.benchmarks.timing import no_progress, Progress, time_interleaved
from bpc_sim.config import SimConfig

PERIOD_S = 2.0  # of captures, for which the share of a core is told
ROUNDS = 5


def run(quick: bool, progress: Progress = no_progress) -> list[dict[str, object]]:
    """Verify that parts of a capture come back to the byte, then time them."""
    sizes = (SMALL,) if quick else (SMALL, FULL)
    rows = []
    for done, size in enumerate(sizes):
        progress(done, len(sizes))
        job = SimConfig(**size).job()
        capture = job.capture(job.duration, 0, round(job.duration * 1e9))
        for message in capture_to_messages(capture):
            if not isinstance(message, CameraInfo):
                rows.append(measured(message, capture.camera.width))
    return rows


def measured(message: object, width: int) -> dict[str, object]:
    """Return the row of a message of a camera with so many pixels in a row."""
    data, kind = serialize_message(message), type(message)
    small = packed(data, kind)
    if unpacked(small) != data:
        raise ValueError(f'bench packing: expected the same {kind.__name__}, found another')
    times = time_interleaved({'pack': partial(packed, data, kind),
                              'unpack': partial(unpacked, small)}, ROUNDS, np.inf)
    return {'what': kind.__name__, 'width_pixels': width, 'mb': len(data) / 1e6,
            'share': len(small) / len(data), 'pack_s': times['pack'].median,
            'unpack_s': times['unpack'].median,
            f'core_share_each_{PERIOD_S:g}_s': times['pack'].median / PERIOD_S}
