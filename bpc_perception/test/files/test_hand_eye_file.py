"""Calibration files of each form, and files that are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.files.hand_eye_file import HandEyeError, load_hand_eye, save_hand_eye
from bpc_perception.files.yaml_file import LARGEST_FILE_BYTES

GOOD = """\
parameters:
  calibration_type: {mount}
  freehand_robot_movement: true
  robot_base_frame: lbr_link_0
  tracking_base_frame: camera
transform:
  translation: {{x: 0.1, y: -0.2, z: 1}}
  rotation: {{x: 0.0, y: 0.0, z: 0.70710678, w: 0.70710678}}
"""


def written(folder: Path, text: str | bytes) -> Path:
    file = folder / 'camera.calib'
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    return file


@pytest.mark.parametrize(('mount', 'on_base'), [('eye_on_base', True), ('eye_in_hand', False)])
def test_both_mounts_are_read(tmp_path: Path, mount: str, on_base: bool) -> None:
    found = load_hand_eye(written(tmp_path, GOOD.format(mount=mount)))
    assert found.on_base == on_base
    np.testing.assert_allclose(
        found.T_parent_camera,
        ((0, -1, 0, 0.1), (1, 0, 0, -0.2), (0, 0, 1, 1), (0, 0, 0, 1)), atol=1e-8)


@pytest.mark.parametrize(('text', 'frames'), [
    (GOOD.format(mount='eye_on_base'), ('lbr_link_0', 'camera')),
    (GOOD.format(mount='eye_in_hand'), ('', 'camera')),
    (GOOD.format(mount='eye_in_hand').replace('robot_base', 'robot_effector'),
     ('lbr_link_0', 'camera'))])
def test_the_names_of_the_frames_are_read_where_they_are_stated(
        tmp_path: Path, text: str, frames: tuple[str, str]) -> None:
    found = load_hand_eye(written(tmp_path, text))
    assert (found.parent_frame, found.camera_frame) == frames


def good_without(*lines: str) -> str:
    return ''.join(line + '\n' for line in GOOD.format(mount='eye_on_base').splitlines()
                   if not line.strip().startswith(lines))


@pytest.mark.parametrize(('text', 'expected'), [
    (good_without('calibration_type'), r'expected .*parameters\.calibration_type, found none'),
    (good_without('translation'), r'expected .*transform\.translation, found none'),
    (good_without('rotation'), r'expected .*transform\.rotation, found none'),
    (GOOD.format(mount='eye_in_foot'), r"expected .*eye_on_base or eye_in_hand, found 'eye_in_fo"),
    (GOOD.format(mount='[eye_on_base]'), r'expected .*eye_on_base or eye_in_hand, found \['),
    (GOOD.format(mount='eye_on_base').replace('w: 0.7', 'w: 0.1'), r'.*length 1, found 0.71'),
    (GOOD.format(mount='eye_on_base').replace('0.70710678', '0.0'), r'.*length 1, found 0; write'),
    (GOOD.format(mount='eye_on_base').replace('x: 0.1', 'x: .nan'), r'pose: expected finite'),
    (GOOD.format(mount='eye_on_base').replace('x: 0.1', 'x: near'), r'expected .*found'),
    (GOOD.format(mount='eye_on_base').replace('x: 0.1, ', ''), r"expected .*found: 'x'"),
    (GOOD.format(mount='eye_on_base').replace('{x: 0.1, y: -0.2, z: 1}', '[1, 2, 3]'),
     r'expected numbers x, y, z, found'),
    (GOOD.format(mount='eye_on_base').replace('x: 0.1', 'x: 700'),
     r'expected a camera within 5 m .*found 700.* millimetres'),
    ('', r'expected a calibration .* transform, .*, found NoneType'),
    ('some words', r'expected a calibration .* transform, .*, found str'),
    ('- a list', r'expected a calibration .* transform, .*, found list'),
    ('pose: {x: 1}', r'expected a calibration .* transform, .*, found pose'),
    ('a: [1, 2', r'expected a readable YAML file, found: '),
    ('a: 2024-99-99', r'expected a readable YAML file, found: '),
    ('!!python/object:os.system {}', r'expected a readable YAML file, found: '),
    (b'\xff\xfe\x00\x01', r'expected a readable YAML file, found: '),
    ('[' * 5000, r'expected a readable YAML file, found: '),
    ('#' * (LARGEST_FILE_BYTES + 1),
     rf'expected a readable YAML file, found: more than {LARGEST_FILE_BYTES} bytes'),
    # A few lines that would become a billion values.
    ('a: &a [1, 1]\nb: &b [*a, *a]\nxyz: [*b, *b]', r'expected a readable .*: an alias, \*a'),
    ('{a: ' * 21 + '}' * 21, r'expected a readable YAML file, found: more than 20 levels'),
    ('a: !!bool x', r'expected a readable YAML file, found: '),
    (f'calibration_type: eye_on_base\nunit: m\nxyz: [0, 0, {"9" * 400}]\n'
     'quaternion: [0, 0, 0, 1]', r'expected numbers 0, 1, 2, found: int too large'),
], ids=range(26))
def test_what_is_no_calibration_is_refused_naming_both(tmp_path: Path, text: str | bytes,
                                                       expected: str) -> None:
    file = written(tmp_path, text)
    with pytest.raises(HandEyeError, match=rf'^{file}: {expected}') as refused:
        load_hand_eye(file)
    assert '\n' not in str(refused.value)


# The same pose in the other forms; a quarter turn about z, and 0.1, -0.2, 1 m.
LEGACY = """\
parameters: {{eye_on_hand: {in_hand}, robot_base_frame: lbr_link_0, tracking_base_frame: camera}}
transformation: {{x: 0.1, y: -0.2, z: 1, qx: 0.0, qy: 0.0, qz: 0.70710678, qw: 0.70710678}}
"""
ZIVID = """\
__version__: {{serializer: 1, data: 1}}
FloatMatrix:
  Data: [[0, -1, 0, {x}], [1, 0, 0, {y}], [0, 0, 1, {z}], [0, 0, 0, 1]]
"""
IN_MM = ZIVID.format(x=100, y=-200, z=1000) + 'calibration_type: eye_in_hand\nunit: mm\n'
PLAIN = """\
calibration_type: eye_on_base
unit: m
xyz: [0.1, -0.2, 1]
quaternion: [0, 0, 0.70710678, 0.70710678]
"""
LEGACY_OLD = """\
eye_on_hand: true
robot_base_frame: lbr_link_0
transformation: {x: 0.1, y: -0.2, z: 1, qx: 0.0, qy: 0.0, qz: 0.70710678, qw: 0.70710678}
"""
OPENCV = """\
%YAML:1.0
---
calibration_type: eye_on_base
unit: mm
PoseState: !!opencv-matrix
   rows: 4
   cols: 4
   dt: d
   data: [ 0., -1., 0., 1.0e+02, 1., 0., 0., -2.0e+02, 0., 0., 1., 1.0e+03,
       0., 0., 0., 1. ]
"""
POSE = ((0, -1, 0, 0.1), (1, 0, 0, -0.2), (0, 0, 1, 1), (0, 0, 0, 1))


@pytest.mark.parametrize(('text', 'on_base'), [
    (LEGACY.format(in_hand='true'), False),
    (LEGACY.format(in_hand='false'), True),
    (IN_MM, False),
    (IN_MM.replace('FloatMatrix:\n  Data', 'Data'), False),
    (ZIVID.format(x=0.1, y=-0.2, z=1) + 'calibration_type: eye_on_base\nunit: m\n', True),
    (PLAIN, True),
    (PLAIN.replace('unit: m', 'unit: mm').replace('[0.1, -0.2, 1]', '[100, -200, 1000]'), True),
    (LEGACY_OLD, False), (OPENCV, True),
], ids=range(9))
def test_other_forms_are_read(tmp_path: Path, text: str, on_base: bool) -> None:
    found = load_hand_eye(written(tmp_path, text))
    assert found.on_base == on_base
    np.testing.assert_allclose(found.T_parent_camera, POSE, atol=1e-8)


@pytest.mark.parametrize(('text', 'expected'), [
    (LEGACY.format(in_hand='maybe'), r"expected eye_on_hand true or false, found 'maybe'"),
    (LEGACY.format(in_hand='true').replace('qz: 0.7', 'q: 0.7'), r"expected numbers .*found: 'qz"),
    (LEGACY.format(in_hand='true').replace('eye_on_hand', 'eye'),
     r'expected .*parameters\.eye_on_hand, found none'),
    (IN_MM.replace('unit: mm\n', ''), r'expected unit m or mm, found none'),
    (IN_MM.replace('unit: mm', 'unit: inch'), r"expected unit m or mm, found 'inch'"),
    (IN_MM.replace('unit: mm', 'unit: m'), r'expected a camera within 5 m .*millimetres'),
    (IN_MM.replace('calibration_type: eye_in_hand\n', ''),
     r'expected calibration_type eye_on_base or eye_in_hand, found none'),
    (IN_MM.replace('[0, -1, 0,', '[0, -1.1, 0,'), r'expected a rotation .*none by 0.21'),
    (IN_MM.replace('[0, -1, 0,', '[0, 1, 0,'), r'expected a rotation .*mirrors'),
    (IN_MM.replace('[0, 0, 0, 1]', '[0, 0, 0, 2]'), r'expected Data to end with 0 0 0 1'),
    (IN_MM.replace(', [0, 0, 0, 1]', ''), r'expected Data with 4 x 4 .*found 3 x 4'),
    (IN_MM.replace('[0, 0, 0, 1]', '[0, 0, 0]'), r'expected Data with 4 x 4 numbers'),
    (IN_MM.replace('-200', '.nan'), r'expected Data with 4 x 4 finite'),
    (PLAIN.replace('unit: m\n', ''), r'expected unit m or mm, found none'),
    (OPENCV.replace('rows: 4', 'rows: 3'), r'expected a matrix in its rows, found: '),
    (PLAIN.replace('[0.1, -0.2, 1]', '[0.1, -0.2]'), r'expected xyz as a list of 3 numbers'),
    (PLAIN.replace('quaternion:', 'rotation:'), r'expected quaternion as a list.*found None'),
    (PLAIN.replace('0.1', 'near'), r'expected numbers .*found: .*near'),
    (PLAIN.replace('0.70710678]', '0.1]'), r'.*length 1, found 0.71'),
], ids=range(19))
def test_other_forms_are_refused_naming_both(tmp_path: Path, text: str, expected: str) -> None:
    file = written(tmp_path, text)
    with pytest.raises(HandEyeError, match=rf'^{file}: {expected}') as refused:
        load_hand_eye(file)
    assert '\n' not in str(refused.value)


@pytest.mark.parametrize('on_base', [True, False])
def test_what_is_saved_is_loaded_again(tmp_path: Path, on_base: bool) -> None:
    file = tmp_path / 'new.calib'
    save_hand_eye(file, HandEye(on_base, np.array(POSE, float)), 'cell', 'base', 'ee', 'camera')
    found = load_hand_eye(file)
    assert found.on_base == on_base
    np.testing.assert_allclose(found.T_parent_camera, POSE, atol=1e-12)
    assert [each.name for each in tmp_path.iterdir()] == ['new.calib']


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(HandEyeError, match=r'none\.calib: expected a readable YAML file, found'):
        load_hand_eye(tmp_path / 'none.calib')


def test_a_folder_is_refused() -> None:
    with pytest.raises(HandEyeError, match='expected a readable YAML file, found'):
        load_hand_eye('.')


def test_none_given_is_refused_in_plain_words() -> None:
    with pytest.raises(HandEyeError, match='expected a file, found none given'):
        load_hand_eye('')
