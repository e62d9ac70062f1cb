"""Fuzz targets: calibrations, parameter files and designs."""

from __future__ import annotations

from pathlib import Path

from bpc_perception.core.config import (
    CameraConfig,
    ExtruderConfig,
    RecorderConfig,
    ThicknessConfig,
)
from bpc_perception.files.parameter_file import configure
from bpc_system_tests.parts.command_line import ROOT, SAMPLE


def calibrations() -> list[bytes]:
    """Return one calibration of each form."""
    return [
        (SAMPLE / 'hand_eye.calib').read_bytes(),
        b'parameters: {eye_on_hand: true}\n'
        b'transformation: {x: 0.1, y: 0, z: 0.2, qx: 0, qy: 0, qz: 0, qw: 1}\n',
        b'calibration_type: eye_in_hand\nunit: mm\nFloatMatrix:\n  Data:\n'
        b'  - [1, 0, 0, 10]\n  - [0, 1, 0, 20]\n  - [0, 0, 1, 30]\n  - [0, 0, 0, 1]\n',
        b'calibration_type: eye_on_base\nunit: m\nxyz: [0.1, 0.2, 0.3]\n'
        b'quaternion: [0, 0, 0, 1]\n']


def parameter_files() -> list[bytes]:
    """Return shipped parameter files, that of the sample, and one with nested names."""
    shipped = ROOT / 'bpc_perception' / 'config'
    return [(SAMPLE / 'params.yaml').read_bytes(),
            (shipped / 'path_recorder.yaml').read_bytes(),
            b'/**:\n  ros__parameters:\n    path.spacing: 0.0002\n'
            b'thickness:\n  ros__parameters:\n    method: paper\n'
            b'    advice: {target_thickness: 0.002, target_file: ""}\n']


def g_code_files() -> list[bytes]:
    """Return a short design of each dialect."""
    samples = ROOT / 'bpc_perception' / 'test' / 'files' / 'design' / 'samples'
    # That of a dispenser is read with the names of its commands alone.
    return [file.read_bytes() for file in sorted(samples.iterdir()) if file.stem != 'pressure']


def read_parameters(file: Path) -> object:
    """Read the parameters of each node."""
    return [configure(default, node, file) for default, node in (
        (ThicknessConfig(), 'thickness'), (RecorderConfig(), 'path_recorder'),
        (CameraConfig(), 'camera_driver'), (ExtruderConfig(), 'extruder_bridge'))]
