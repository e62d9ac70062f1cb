"""Hand-eye calibration files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from bpc_perception.core.poses import pose_matrix
from bpc_perception.core.session import HandEye

MOUNTS = {'eye_on_base': True, 'eye_in_hand': False}
SIZE_LIMIT = 1_000_000


class HandEyeError(ValueError):
    """A calibration file is not what was expected; the message names both."""


def load_hand_eye(path: str | Path) -> HandEye:
    """Read an easy_handeye2 ``.calib`` file: YAML with ``parameters`` and ``transform``.

    Its transform is the pose of the camera's optical frame in the robot base frame
    (``eye_on_base``) or flange frame (``eye_in_hand``), in metres.
    """
    if not str(path):
        raise HandEyeError('hand-eye calibration: expected a file, found none given')
    path = Path(path)
    try:
        if path.stat().st_size > SIZE_LIMIT:
            size = path.stat().st_size
            raise HandEyeError(f'{path}: expected a calibration, found {size} bytes')
        content = yaml.safe_load(path.read_text(encoding='utf-8'))
    except HandEyeError:
        raise
    # PyYAML lets ValueError through for dates such as 2024-99-99, and RecursionError.
    except (OSError, ValueError, RecursionError, yaml.YAMLError) as error:
        problem = getattr(error, 'strerror', None) or str(error).splitlines()[0]
        raise HandEyeError(f'{path}: expected a readable YAML file, found: {problem}') from error
    mount = _entry(content, 'parameters', 'calibration_type', path)
    if not isinstance(mount, str) or mount not in MOUNTS:
        raise HandEyeError(f'{path}: expected calibration_type {" or ".join(MOUNTS)}, '
                           f'found {mount!r}')
    translation = _entry(content, 'transform', 'translation', path)
    rotation = _entry(content, 'transform', 'rotation', path)
    try:
        pose = pose_matrix(np.array([float(translation[axis]) for axis in 'xyz']),
                           np.array([float(rotation[axis]) for axis in 'xyzw']))
    except (KeyError, TypeError, ValueError) as error:
        raise HandEyeError(f'{path}: expected translation x, y, z and rotation x, y, z, w, '
                           f'found: {error}') from error
    return HandEye(MOUNTS[mount], pose)


def _entry(content: Any, group: str, key: str, path: Path) -> Any:
    try:
        return content[group][key]
    except (KeyError, TypeError):
        raise HandEyeError(f'{path}: expected an easy_handeye2 calibration with {group}.{key}, '
                           'found none') from None
