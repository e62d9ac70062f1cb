"""Calibration files of easy_handeye2, and what is none."""

from __future__ import annotations

from pathlib import Path

from bpc_perception.handeye import HandEyeError, load_hand_eye, SIZE_LIMIT
import numpy as np
import pytest

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
    (GOOD.format(mount='eye_on_base').replace('0.70710678', '0.0'), r'.*length 1, found 0$'),
    (GOOD.format(mount='eye_on_base').replace('x: 0.1', 'x: .nan'), r'expected .*finite'),
    (GOOD.format(mount='eye_on_base').replace('x: 0.1', 'x: near'), r'expected .*found'),
    (GOOD.format(mount='eye_on_base').replace('x: 0.1, ', ''), r"expected .*found: 'x'"),
    (GOOD.format(mount='eye_on_base').replace('{x: 0.1, y: -0.2, z: 1}', '[1, 2, 3]'),
     r'expected translation x, y, z'),
    ('', r'expected an easy_handeye2 calibration'),
    ('some words', r'expected an easy_handeye2 calibration'),
    ('- a list', r'expected an easy_handeye2 calibration'),
    ('a: [1, 2', r'expected a readable YAML file, found: '),
    ('a: 2024-99-99', r'expected a readable YAML file, found: '),
    ('!!python/object:os.system {}', r'expected a readable YAML file, found: '),
    (b'\xff\xfe\x00\x01', r'expected a readable YAML file, found: '),
    ('[' * 5000, r'expected a readable YAML file, found: '),
    ('#' * (SIZE_LIMIT + 1), rf'expected a calibration, found {SIZE_LIMIT + 1} bytes'),
], ids=range(20))
def test_what_is_no_calibration_is_refused_naming_both(tmp_path: Path, text: str | bytes,
                                                       expected: str) -> None:
    file = written(tmp_path, text)
    with pytest.raises(HandEyeError, match=rf'^{file}: {expected}') as refused:
        load_hand_eye(file)
    assert '\n' not in str(refused.value)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(HandEyeError, match=r'none\.calib: expected a readable YAML file, found'):
        load_hand_eye(tmp_path / 'none.calib')


def test_a_folder_is_refused() -> None:
    with pytest.raises(HandEyeError, match='expected a readable YAML file, found'):
        load_hand_eye('.')


def test_none_given_is_refused_in_plain_words() -> None:
    with pytest.raises(HandEyeError, match='expected a file, found none given'):
        load_hand_eye('')
