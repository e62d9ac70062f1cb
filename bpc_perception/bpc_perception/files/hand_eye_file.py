"""Read and write hand-eye calibration files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation
import yaml

from bpc_perception.core.arrays import Array
from bpc_perception.core.robot.hand_eye import HandEye, mount_name, MOUNTS
from bpc_perception.core.robot.poses import pose_matrix
from bpc_perception.files.yaml_file import FileError, read_yaml

UNITS_M = {'m': 1.0, 'mm': 1e-3}
# Farther is beyond the reach of the robot and its camera; then millimetres were taken for metres.
LARGEST_DISTANCE_M = 5.0
ROTATION_TOLERANCE = 1e-4  # how far a matrix in single precision may be from a rotation


class HandEyeError(ValueError):
    """A calibration file is not what was expected; the message names both."""


def load_hand_eye(path: str | Path) -> HandEye:
    """Read a hand-eye calibration: the pose of the camera's optical frame in its parent frame.

    The parent is the robot base (``eye_on_base``) or the flange (``eye_in_hand``). The file is
    YAML in one of four forms, which differ in their keys:

    - ``transform``: easy_handeye2, metres, the mount in ``parameters.calibration_type``;
    - ``transformation``: easy_handeye of ROS 1, metres, the mount in ``parameters.eye_on_hand``
      or, of old versions, in ``eye_on_hand``;
    - ``Data``, by itself or one level down: a 4x4 matrix, as the Zivid SDK saves it, or a matrix
      of cv2.FileStorage, as the samples of its vendor write;
    - ``xyz`` and ``quaternion``: lists, the quaternion as x, y, z, w.

    The last two state neither mount nor unit, so the keys ``calibration_type`` and ``unit``
    (``mm`` or ``m``) have to be added at the top level: neither is guessed.

    Raises HandEyeError.
    """
    if not str(path):
        raise HandEyeError('hand-eye calibration: expected a file, found none given'
                           '; name it with --handeye, or as hand_eye_file')
    path = Path(path)
    content = _read(path)
    try:
        hand_eye = FORMS[_form(content)](content)
    except HandEyeError as error:
        raise HandEyeError(f'{path}: {error}') from None
    distance = float(np.linalg.norm(hand_eye.T_parent_camera[:3, 3]))
    if distance > LARGEST_DISTANCE_M:
        raise HandEyeError(f'{path}: expected a camera within {LARGEST_DISTANCE_M:g} m of its '
                           f'parent frame, found {distance:g} m; is it in millimetres?')
    return hand_eye


def save_hand_eye(path: str | Path, hand_eye: HandEye, name: str, base_frame: str,
                  flange_frame: str, camera_frame: str) -> None:
    """Write a calibration in the form of easy_handeye2, whole or not at all. Raises OSError."""
    path = Path(path)
    mount = mount_name(hand_eye.on_base)
    rotation = Rotation.from_matrix(hand_eye.T_parent_camera[:3, :3]).as_quat()
    content = {
        'parameters': {
            'name': name, 'calibration_type': mount, 'robot_base_frame': base_frame,
            'robot_effector_frame': flange_frame, 'tracking_base_frame': camera_frame,
            'tracking_marker_frame': 'board', 'freehand_robot_movement': True,
            'move_group_namespace': '/', 'move_group': ''},
        'transform': {
            'translation': _axes('xyz', hand_eye.T_parent_camera[:3, 3]),
            'rotation': _axes('xyzw', rotation)}}
    temporary = path.with_name(path.name + '.tmp')
    temporary.write_text(yaml.safe_dump(content, sort_keys=False), encoding='utf-8')
    temporary.replace(path)


def _read(path: Path) -> dict[str, Any]:
    try:
        content = read_yaml(path)
    except FileError as error:
        raise HandEyeError(f'{path}: {error}') from error
    if not isinstance(content, dict):
        raise HandEyeError(f'{path}: expected a calibration with one of the keys '
                           f'{", ".join(FORMS)}, found {type(content).__name__}'
                           '; see docs/tutorials/calibrate.md for the forms')
    return content


def _form(content: dict[str, Any]) -> str:
    """Return the key of FORMS that the content has; that of a matrix may be one level down."""
    for key in FORMS:
        if key in content:
            return key
    if _find_matrix(content) is None:
        raise HandEyeError(f'expected a calibration with one of the keys {", ".join(FORMS)}, '
                           f'found {", ".join(map(str, content)) or "none"}'
                           '; see docs/tutorials/calibrate.md for the forms')
    return 'Data'


def _easy_handeye2(content: dict[str, Any]) -> HandEye:
    on_base = _mount(_entry(content, 'parameters', 'calibration_type'))
    return HandEye(on_base, _pose(_numbers(_entry(content, 'transform', 'translation'), 'xyz'),
                                  _numbers(_entry(content, 'transform', 'rotation'), 'xyzw')),
                   *_frames(content, on_base))


def _easy_handeye(content: dict[str, Any]) -> HandEye:
    in_hand = (content['eye_on_hand'] if 'eye_on_hand' in content
               else _entry(content, 'parameters', 'eye_on_hand'))
    if not isinstance(in_hand, bool):
        raise HandEyeError(f'expected eye_on_hand true or false, found {in_hand!r}'
                           '; write one of them')
    numbers = _numbers(content['transformation'], ('x', 'y', 'z', 'qx', 'qy', 'qz', 'qw'))
    return HandEye(not in_hand, _pose(numbers[:3], numbers[3:]), *_frames(content, not in_hand))


def _frames(content: dict[str, Any], on_base: bool) -> tuple[str, str]:
    """Return the names of the parent's and the camera's frame; empty where they are not stated.

    easy_handeye keeps them among its parameters, old versions of it beside the transformation.
    """
    stated = content.get('parameters', content)
    if not isinstance(stated, dict):
        return '', ''
    parent = 'robot_base_frame' if on_base else 'robot_effector_frame'
    return str(stated.get(parent) or ''), str(stated.get('tracking_base_frame') or '')


def _matrix(content: dict[str, Any]) -> HandEye:
    try:
        T_parent_camera = np.array(_find_matrix(content), np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise HandEyeError(f'expected Data with 4 x 4 numbers, found: {error}'
                           '; write all sixteen') from error
    if T_parent_camera.shape != (4, 4) or not np.isfinite(T_parent_camera).all():
        raise HandEyeError('expected Data with 4 x 4 finite numbers, found '
                           f'{" x ".join(map(str, T_parent_camera.shape))}; write all sixteen')
    R = T_parent_camera[:3, :3]
    _expect_rotation(R)
    if not np.allclose(T_parent_camera[3], (0, 0, 0, 1)):
        raise HandEyeError(f'expected Data to end with 0 0 0 1, found {T_parent_camera[3]}'
                           '; write its rows in that order')
    T_parent_camera[:3, :3] = Rotation.from_matrix(R).as_matrix()
    T_parent_camera[:3, 3] *= _unit(content)
    return HandEye(_mount(content.get('calibration_type')), T_parent_camera)


def _expect_rotation(R: Array) -> None:
    excess = float(np.abs(R @ R.T - np.eye(3)).max())
    if excess > ROTATION_TOLERANCE:
        raise HandEyeError('expected a rotation in Data, found a matrix that is none by '
                           f'{excess:.2g}; write more digits, or calibrate anew')
    if np.linalg.det(R) < 0:
        raise HandEyeError('expected a rotation in Data, found a matrix that mirrors'
                           '; calibrate anew')


def _plain(content: dict[str, Any]) -> HandEye:
    numbers = []
    for key, length in (('xyz', 3), ('quaternion', 4)):
        values = content.get(key)
        if not isinstance(values, list) or len(values) != length:
            raise HandEyeError(f'expected {key} as a list of {length} numbers, found {values!r}'
                               '; write one')
        numbers.append(_numbers(dict(enumerate(values)), range(length)))
    return HandEye(_mount(content.get('calibration_type')),
                   _pose(_unit(content) * numbers[0], numbers[1]))


FORMS: dict[str, Callable[[dict[str, Any]], HandEye]] = {
    'transform': _easy_handeye2, 'transformation': _easy_handeye, 'Data': _matrix, 'xyz': _plain}


def _find_matrix(content: dict[str, Any]) -> Any:
    """Return the value of ``Data``, which the SDK puts below a key that names the type.

    Or that of a matrix of cv2.FileStorage, in its rows.
    """
    inner = [value['Data'] for value in content.values()
             if isinstance(value, dict) and 'Data' in value]
    for value in content.values():
        if isinstance(value, dict) and value.keys() >= {'rows', 'cols', 'data'}:
            try:
                inner.append(np.reshape(value['data'], (value['rows'], value['cols'])).tolist())
            except (TypeError, ValueError) as error:
                raise HandEyeError(f'expected a matrix in its rows, found: {error}'
                                   '; save it anew') from error
    return content.get('Data', inner[0] if len(inner) == 1 else None)


def _mount(name: Any) -> bool:
    if not isinstance(name, str) or name not in MOUNTS:
        found = 'none' if name is None else repr(name)
        raise HandEyeError(f'expected calibration_type {" or ".join(MOUNTS)}, found {found}; '
                           'write where the camera is')
    return MOUNTS[name]


def _unit(content: dict[str, Any]) -> float:
    unit = content.get('unit')
    if not isinstance(unit, str) or unit not in UNITS_M:
        found = 'none' if unit is None else repr(unit)
        raise HandEyeError(f'expected unit {" or ".join(UNITS_M)}, found {found}; write that of '
                           'the matrix')
    return UNITS_M[unit]


def _entry(content: dict[str, Any], group: str, key: str) -> Any:
    try:
        return content[group][key]
    except (KeyError, TypeError):
        raise HandEyeError(f'expected a calibration with {group}.{key}, found none'
                           '; add it') from None


def _numbers(values: Any, keys: Any) -> Array:
    try:
        return np.array([float(values[key]) for key in keys])
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise HandEyeError(f'expected numbers {", ".join(map(str, keys))}, '
                           f'found: {error}; write them') from error


def _pose(translation: Array, quaternion: Array) -> Array:
    try:
        return pose_matrix(translation, quaternion)
    except ValueError as error:
        raise HandEyeError(f'{error}; write metres, and x, y, z, w of the quaternion') from error


def _axes(names: str, values: Array) -> dict[str, float]:
    return dict(zip(names, values.tolist(), strict=True))
