"""Where a result comes from."""

from __future__ import annotations

from dataclasses import dataclass
import hashlib
from importlib import metadata
import json
from pathlib import Path
import platform

import cv2
import numpy as np

from bpc_perception import __version__
from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.parameter import flatten
from bpc_perception.recording.inputs import Inputs


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from.

    Attributes:
        bag: the recording, as the user named it.
        hand_eye: file of the hand-eye calibration.
        settings: dotted names and values of the ThicknessConfig.
        versions: see versions().
        targets: the thickness wanted along the path; None = none.
        fingerprint: changes whenever one of what the result is made of does.
    """

    bag: str
    hand_eye: str
    settings: dict[str, object]
    versions: dict[str, str]
    targets: WidthTargets | None = None
    fingerprint: str = ''


def versions() -> dict[str, str]:
    """Versions of everything that can change a number."""
    try:
        ros = f'rclpy {metadata.version("rclpy")}'
    except metadata.PackageNotFoundError:
        ros = 'none'
    return {'bpc': __version__, 'python': platform.python_version(), 'numpy': np.__version__,
            'opencv': cv2.__version__, 'ros': ros}


def fingerprint(given: Inputs, settings: dict[str, object], found: dict[str, str]) -> str:
    """Tells whether a result is made of the same: recording, calibration, settings, versions.

    Of a recording names, sizes and times of change are looked at, as make and rsync do; of the
    small files their content.
    """
    told = hashlib.sha256(json.dumps([settings, found], sort_keys=True, default=str).encode())
    for file in given.bag.files:
        state = file.stat()
        told.update(f'{file.name} {state.st_size} {state.st_mtime_ns}'.encode(errors='replace'))
    targets = given.thickness.advice.target_file
    for small in (given.hand_eye_file, *([Path(targets)] if targets else [])):
        told.update(small.read_bytes())
    return told.hexdigest()


def provenance_of(given: Inputs) -> Provenance:
    """What the outputs say of where they come from."""
    settings = {name: value for name, _, value in flatten(given.thickness)}
    settings |= {f'path_recorder.{name}': value for name, _, value in flatten(given.recorder)}
    found = versions()
    return Provenance(str(given.bag.path), str(given.hand_eye_file), settings, found,
                      given.targets, fingerprint(given, settings, found))
