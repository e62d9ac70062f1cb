"""The sample print as it is measured, and a long print made of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.result import Result
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.files.parameter_file import configure
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.offline import measure_bag
from bpc_system_tests.parts.command_line import SAMPLE

LONG_PRINT_M = 2.0  # length of its path
SAMPLE_SPACING_M = 2e-4  # of that path
CAPTURES = 200  # of a long print


def settings(bag: Path = SAMPLE) -> ThicknessConfig:
    """Return the parameters of the thickness node in the sample recording, or another."""
    return configure(ThicknessConfig(), 'thickness', bag / 'params.yaml')


def sample_results(bag: Path = SAMPLE) -> list[Result]:
    """Measure every capture of the sample print, or of another recording."""
    return list(measure_bag(
        Bag(bag), load_hand_eye(bag / 'hand_eye.calib'), settings(bag),
        configure(RecorderConfig(), 'path_recorder', bag / 'params.yaml')))


def long_print(result: Result, capture: int) -> Result:
    """Return a capture of a print of 2 m that repeats the path of a result again and again."""
    profile = result.profile
    assert profile is not None
    count = round(LONG_PRINT_M / SAMPLE_SPACING_M * (capture + 1) / CAPTURES)
    again = np.arange(count) % len(profile)
    arrays = {name: getattr(profile, name)[again] for name in (
        'points', 'extruding', 'status', 'thickness', 'sigma', 'left', 'right', 'left_points',
        'right_points')}
    return replace(result, profile=replace(
        profile, capture=capture, arc_length=np.arange(count) * SAMPLE_SPACING_M,
        time=np.arange(count) * 0.01, **arrays))


def enlarged(result: Result, factor: int) -> Result:
    """Return a result as if the camera had ``factor`` times the pixels per side."""
    capture = result.capture
    # Pixel centres have integer coordinates.
    K = np.diag((factor, factor, 1.0)) @ capture.camera.K
    K[:2, 2] += (factor - 1) / 2
    camera = replace(capture.camera, K=K, width=factor * capture.camera.width,
                     height=factor * capture.camera.height)
    image, cloud = (np.asarray(cv2.resize(field, (camera.width, camera.height)), field.dtype)
                     for field in (capture.image, capture.cloud))
    return replace(result, capture=replace(capture, image=image, cloud=cloud, camera=camera))
