"""Where a result comes from."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field
import hashlib
from importlib import metadata
import json
from pathlib import Path
import platform
from typing import Any

import cv2
import numpy as np

from bpc_perception import __version__
from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.parameter import flatten
from bpc_perception.core.result import Result
from bpc_perception.core.targets import WidthTargets
from bpc_perception.recording.inputs import Inputs, targets_of


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from.

    Attributes:
        bag: the recording, by its absolute path.
        hand_eye: file of the hand-eye calibration.
        settings: dotted names and values of the ThicknessConfig.
        versions: see versions().
        targets: the thickness wanted along the path; None = none.
        fingerprint: see fingerprint().
        contents: see contents_of().
    """

    bag: str
    hand_eye: str
    settings: dict[str, object]
    versions: dict[str, str]
    targets: WidthTargets | None = None
    fingerprint: str = ''
    contents: dict[str, str] = field(default_factory=dict)

    def targets_of(self, result: Result) -> WidthTargets | None:
        """Return the thickness wanted along a result that was measured: its design's, if told."""
        if result.design is None or result.profile is None:
            return self.targets
        return result.design.targets(result.profile.arc_length, self.targets)


def versions() -> dict[str, str]:
    """Return the versions of everything that can change a number."""
    try:
        ros = f'rclpy {metadata.version("rclpy")}'
    except metadata.PackageNotFoundError:
        ros = 'none'
    return {'bpc': __version__, 'python': platform.python_version(), 'numpy': np.__version__,
            'opencv': cv2.__version__, 'ros': ros}


def fingerprint(recording: Inputs, settings: dict[str, object],
                used_versions: dict[str, str]) -> str:
    """Return a hash that is the same only if a result is made from the same.

    It covers recording, calibration, targets, settings and versions: the content of the small
    files, but only names, sizes and times of change of the recording, as make and rsync do.
    """
    digest = _digest(settings, used_versions)
    for rule in sorted(recording.bag.others.items()):
        digest.update(repr(rule).encode(errors='replace'))
    for file in recording.bag.files:
        state = file.stat()
        digest.update(f'{file.name} {state.st_size} {state.st_mtime_ns}'.encode(errors='replace'))
    thickness = recording.thickness
    for small_file in filter(None, (str(recording.hand_eye_file), thickness.advice.target_file,
                                    thickness.design.file)):
        digest.update(Path(small_file).read_bytes())
    return digest.hexdigest()


def settings_of(thickness: ThicknessConfig, recorder: RecorderConfig) -> dict[str, object]:
    """Return dotted names and values of all settings that a result depends on."""
    settings = {name: value for name, _, value in flatten(thickness)}
    return settings | {f'path_recorder.{name}': value for name, _, value in flatten(recorder)}


def contents_of(thickness: ThicknessConfig) -> dict[str, str]:
    """Return a hash of each file that settings name, by their dotted names.

    Copies of one file lie beside many recordings, and files of one name need not be alike. A file
    that cannot be read any more is left out: a live print is not lost with it.
    """
    named = {'advice.target_file': thickness.advice.target_file,
             'design.file': thickness.design.file}
    contents: dict[str, str] = {}
    for name, file in named.items():
        with suppress(OSError):
            contents |= {name: hashlib.sha256(Path(file).read_bytes()).hexdigest()} if file else {}
    return contents


def provenance_of(recording: Inputs) -> Provenance:
    """Return what the files say about where a result comes from."""
    settings = settings_of(recording.thickness, recording.recorder)
    used_versions = versions()
    return Provenance(str(recording.bag.path.absolute()), str(recording.hand_eye_file), settings,
                      used_versions, recording.targets,
                      fingerprint(recording, settings, used_versions),
                      contents_of(recording.thickness))


def live_provenance(recording: Path, hand_eye_file: Path, thickness: ThicknessConfig,
                    recorder: RecorderConfig) -> Provenance:
    """Return where a live result comes from.

    Its recording still grows, so only calibration, settings and versions are in its fingerprint.
    """
    settings, used_versions = settings_of(thickness, recorder), versions()
    digest = _digest(settings, used_versions)
    digest.update(hand_eye_file.read_bytes())
    return Provenance(str(recording), str(hand_eye_file), settings, used_versions,
                      targets_of(thickness.advice), digest.hexdigest(), contents_of(thickness))


def _digest(settings: dict[str, object], used_versions: dict[str, str]) -> Any:
    return hashlib.sha256(
        json.dumps([settings, used_versions], sort_keys=True, default=str).encode())
