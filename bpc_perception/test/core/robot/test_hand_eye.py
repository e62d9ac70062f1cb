"""A calibration that may be another camera's is noticed."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_perception.core.robot.hand_eye import HandEye


@pytest.mark.parametrize(('on_base', 'parent', 'camera', 'found'), [
    (True, 'base', 'camera', ''), (True, '/base', 'camera/', ''), (True, '', '', ''),
    (True, 'base', 'camera_link', 'the camera frame camera_link instead of camera;'),
    (True, 'world', 'camera', 'the base frame world instead of base;'),
    (True, 'world', 'link', 'the camera frame link instead of camera and the base frame world '
                            'instead of base;'),
    (False, 'tool0', 'camera', '')])  # what the flange is called is not known
def test_frames_of_other_names_are_named(on_base: bool, parent: str, camera: str,
                                         found: str) -> None:
    said = HandEye(on_base, np.eye(4), parent, camera).contradiction('base', 'camera')
    assert (found in said) if found else said == ''
