"""Recordings of simulated prints, made without a graph: the same seed gives the same bag."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation
import yaml

from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.recording.bag_writer import BagWriter
from bpc_sim.printer.messages import extruder_message, EXTRUDER_RATE, robot_message
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import POSE_RATE

START_NS = 1_790_000_000_000_000_000  # an arbitrary but fixed date
CAMERA_LATENCY_NS = 120_000_000  # from the stamp of a capture to its messages
HAND_EYE, PARAMETERS = 'hand_eye.calib', 'params.yaml'


def record(job: PrintJob, folder: str | Path, capture_period: float, target: float,
           progress: Callable[[int, int], None] | None = None) -> None:
    """Write a print to a new bag, with captures every ``capture_period`` seconds and at its end.

    The hand-eye calibration and the parameters that belong to it, nozzle offset and
    ``target`` thickness [m], are put beside the recording. ``progress`` is told how many captures
    of how many are done.
    """
    times = [*np.arange(capture_period, job.duration - capture_period / 2, capture_period),
             job.duration]
    events = [(START_NS + round(1e9 * t), topics.POSE, t)
              for t in np.arange(0, job.duration + 0.5, 1 / POSE_RATE)]
    events += [(START_NS + round(1e9 * t), topics.EXTRUSION, t)
               for t in np.arange(0, job.duration + 0.5, 1 / EXTRUDER_RATE)]
    events += [(START_NS + round(1e9 * t) + CAMERA_LATENCY_NS, topics.IMAGE, t) for t in times]
    with BagWriter(folder, compress=True) as bag:
        for name, kind in (topics.PRINT | topics.CAMERA).items():
            bag.add_topic(f'/{name}', topics.type_name(kind))
        for log_ns, name, t in sorted(events):
            stamp_ns = START_NS + round(1e9 * t)
            if name == topics.POSE:
                bag.write(f'/{name}', log_ns, robot_message(job, t, stamp_ns))
            elif name == topics.EXTRUSION:
                bag.write(f'/{name}', log_ns, extruder_message(job, t, stamp_ns))
            else:
                capture = job.capture(t, times.index(t), stamp_ns)
                messages = capture_to_messages(capture)
                for camera_topic, message in zip(topics.CAMERA, messages, strict=True):
                    bag.write(f'/{camera_topic}', log_ns, message)
                if progress is not None:
                    progress(times.index(t) + 1, len(times))
    (Path(folder) / HAND_EYE).write_text(yaml.safe_dump(hand_eye(job), sort_keys=False))
    (Path(folder) / PARAMETERS).write_text(yaml.safe_dump(parameters(job, target)))


def hand_eye(job: PrintJob) -> dict[str, object]:
    """The true pose of the job's camera as an easy_handeye2 calibration."""
    pose = job.view.T_base_camera
    rotation = Rotation.from_matrix(pose[:3, :3]).as_quat()
    return {
        'parameters': {'name': 'synthetic', 'calibration_type': 'eye_on_base',
                       'robot_base_frame': 'lbr_link_0', 'robot_effector_frame': 'lbr_link_ee',
                       'tracking_base_frame': 'zivid_optical_frame'},
        'transform': {
            'translation': dict(zip('xyz', pose[:3, 3].tolist(), strict=True)),
            'rotation': dict(zip('xyzw', rotation.tolist(), strict=True))}}


def parameters(job: PrintJob, target: float) -> dict[str, object]:
    """The parameters of the nodes for this job, in whatever namespace they are."""
    offset = np.asarray(job.nozzle_offset, float).tolist()
    return {'/**/path_recorder': {'ros__parameters': {'nozzle_offset': offset}},
            '/**/thickness': {'ros__parameters': {'advice.target_thickness': target}}}
