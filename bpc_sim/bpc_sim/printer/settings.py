"""Hand-eye calibration and node parameters that belong to a simulated print."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation
import yaml

from bpc_sim.printer.print_job import PrintJob


@dataclass(frozen=True)
class SettingsFiles:
    """The files that the nodes need for a print.

    Attributes:
        hand_eye: hand-eye calibration.
        parameters: parameter file of the nodes.
    """

    hand_eye: Path
    parameters: Path


def write_settings(job: PrintJob, target: float, folder: Path) -> SettingsFiles:
    """Write calibration and parameters of a print into a folder; ``target`` thickness in [m]."""
    files = SettingsFiles(folder / 'hand_eye.calib', folder / 'params.yaml')
    files.hand_eye.write_text(yaml.safe_dump(hand_eye_calibration(job), sort_keys=False))
    files.parameters.write_text(yaml.safe_dump(node_parameters(job, target)))
    return files


def hand_eye_calibration(job: PrintJob) -> dict[str, object]:
    """Return the true pose of the job's camera as an easy_handeye2 calibration."""
    pose = job.view.T_base_camera
    rotation = Rotation.from_matrix(pose[:3, :3]).as_quat()
    return {
        'parameters': {'name': 'synthetic', 'calibration_type': 'eye_on_base',
                       'robot_base_frame': 'lbr_link_0', 'robot_effector_frame': 'lbr_link_ee',
                       'tracking_base_frame': 'camera_optical_frame'},
        'transform': {
            'translation': dict(zip('xyz', pose[:3, 3].tolist(), strict=True)),
            'rotation': dict(zip('xyzw', rotation.tolist(), strict=True))}}


def node_parameters(job: PrintJob, target: float) -> dict[str, object]:
    """Return the nodes' parameters for this job, in any namespace; ``target`` in [m]."""
    offset = np.asarray(job.nozzle_offset, float).tolist()
    return {'/**/path_recorder': {'ros__parameters': {'nozzle_offset': offset}},
            '/**/thickness': {'ros__parameters': {'advice.target_thickness': target}}}
