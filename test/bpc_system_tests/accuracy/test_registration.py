"""Calibrations and nozzle offsets that do not fit: said first, with what to look at.

The recording is one of this suite. What is given with it is wrong in one way each time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import invert
from bpc_perception.core.measurement.bed import find_bed
from bpc_perception.core.measurement.registration import find_shift
from bpc_perception.core.measurement.view import View
from bpc_perception.core.profile import Status
from bpc_perception.core.result import Result
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.recording import inputs
from bpc_perception.recording.offline import measure_bag
from bpc_sim.stress.catalogue import STRESS
from bpc_sim.stress.stress_scene import StressScene
from bpc_system_tests.parts.command_line import SAMPLE

pytestmark = [pytest.mark.accuracy, pytest.mark.ros, pytest.mark.timeout(120)]
MM = 1e-3
WIDTH = 2 * MM  # of the bead in the recording, more or less
AGREES = 0.4 * MM  # a fifth of the width
MOVED = np.array((3.1, 1.2, 0.0)) * MM


@pytest.fixture(scope='module')
def recording() -> inputs.Inputs:
    """A spiral with gaps, seen by a camera on the base."""
    return inputs.load(SAMPLE, None, None)


def results(recording: inputs.Inputs, hand_eye: HandEye | None = None,
            nozzle: Sequence[float] | None = None) -> list[Result]:
    """Measure a recording with another calibration, or another nozzle offset [m]."""
    recorder = recording.recorder
    if nozzle is not None:
        recorder = replace(recorder, nozzle_offset=tuple(nozzle))
    return list(measure_bag(recording.bag, hand_eye or recording.hand_eye,
                            recording.thickness, recorder))


def moved(recording: inputs.Inputs, shift: Sequence[float]) -> HandEye:
    """Return the calibration with the camera elsewhere, by a shift in the base frame [mm]."""
    pose = recording.hand_eye.T_parent_camera.copy()
    pose[:3, 3] += np.array(shift) * MM
    return replace(recording.hand_eye, T_parent_camera=pose)


def test_a_sound_recording_is_not_warned_of(recording: inputs.Inputs) -> None:
    for result in results(recording):
        assert result.warning == ''
        assert result.advice is not None
        assert result.advice.reason != Reason.PATH_OFFSET


@pytest.mark.parametrize('shift', [(0.7, 0, 0), (0, 0.9, 0), (0, -1.5, 0), (2, 1, 0), (-3, 3, 0),
                                   (5, 0, 0), (0, -7, 0)])
def test_ink_beside_its_path_is_the_verdict(recording: inputs.Inputs,
                                            shift: tuple[float, ...]) -> None:
    for result in results(recording, moved(recording, shift)):
        assert result.advice is not None
        assert result.profile is not None
        assert not result.advice.valid
        assert result.advice.reason == Reason.PATH_OFFSET
        assert result.warning.startswith('registration: expected the ink within 25%')
        np.testing.assert_allclose(result.profile.shift, np.array(shift) * MM, atol=AGREES)
        # Beyond half the width nothing is told: the nearest edges may be those of other ink.
        measured = (result.profile.status == Status.MEASURED).any()
        assert measured == (np.linalg.norm(shift) * MM < WIDTH / 2)


@pytest.mark.parametrize(('z', 'where'), [(3.0, 'below'), (-3.0, 'above')])
def test_a_nozzle_that_seems_to_be_off_the_bed_is_the_verdict(
        recording: inputs.Inputs, z: float, where: str) -> None:
    for result in results(recording, moved(recording, (0, 0, z))):
        assert result.advice is not None
        assert result.advice.reason == Reason.PATH_OFFSET
        assert f'mm {where}; correct z of the nozzle offset' in result.warning


def test_of_a_path_out_of_view_it_is_said_what_would_fit(recording: inputs.Inputs) -> None:
    camera = recording.hand_eye
    nozzle = np.array(recording.recorder.nozzle_offset)
    wrong = {
        'with calibration_type eye_on_base': (replace(camera, on_base=False), None),
        'with the inverse of the calibration': (
            replace(camera, T_parent_camera=invert(camera.T_parent_camera)), None),
        'with the nozzle offset of the other sign': (None, -nozzle),
        'the path is that of the flange itself: is nozzle_offset set?': (None, 0 * nozzle),
        'mm to the left of what the camera sees': (moved(recording, (500, 0, 0)), None),
    }
    for words, (hand_eye, offset) in wrong.items():
        found = results(recording, hand_eye, offset)
        assert {result.profile for result in found} == {None}
        assert all(words in result.refusal for result in found), words


@pytest.mark.parametrize('name', STRESS)
def test_a_shift_is_found_in_hard_pictures_and_none_where_there_is_none(name: str) -> None:
    scene = STRESS[name](0)
    width = float(np.median(scene.thickness[scene.thickness > 0]))
    assert np.linalg.norm(shift_in(scene, np.zeros(3), width)) < width / 4
    # Along a single line a shift is seen at its ends alone; the lamp falls by more than 15 levels.
    if name not in ('hardware_line', 'low_contrast_15'):
        assert np.linalg.norm(shift_in(scene, MOVED, width) - MOVED) < width / 2


def shift_in(scene: StressScene, shift: Array, width: float) -> Array:
    """Return the shift that is found in a scene whose camera is moved by another (3,) [m]."""
    pose = scene.T_base_camera.copy()
    pose[:3, 3] += shift
    view = View(scene.capture, pose)
    points = scene.path.points[view.inside(scene.path.points)]
    return find_shift(view, points, find_bed(view, points), width)
