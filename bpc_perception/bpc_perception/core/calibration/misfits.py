"""Which of mount, calibration and nozzle offset to look at where the camera sees no path.

What else they may mean is tried: with one of these the path runs along what the cloud shows.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture, sample_cloud
from bpc_perception.core.geometry import invert, transform
from bpc_perception.core.measurement.view import View
from bpc_perception.core.robot.hand_eye import HandEye, mount_name

NEAR_M = 0.03  # of the cloud, the path would lie on it
FITS = 0.5  # share of the path
AT_FLANGE_M = 1e-3  # a nozzle offset that is less is none
PROBES = 60


def what_would_fit(capture: Capture, points: Array, hand_eye: HandEye, T_base_camera: Array,
                   T_base_flange: Array | None) -> str:
    """Return what would put a path into the picture, or where it lies; empty = it is in there.

    Args:
        capture: of the camera.
        points: (N, 3) of the path, whose last is where the nozzle is [m].
        hand_eye: the calibration.
        T_base_camera: (4, 4) pose of the camera by it.
        T_base_flange: (4, 4) pose of the flange at the capture; None = not known.
    """
    if not len(points) or on_cloud(capture, points, T_base_camera) >= FITS:
        return ''
    found = [name for name, pose, moved in _others(points, hand_eye, T_base_camera, T_base_flange)
             if on_cloud(capture, moved, pose) >= FITS]
    if found:
        return f'; the path would be seen with {" or with ".join(found)}'
    if T_base_flange is not None and _is_at(points[-1], T_base_flange):
        return '; the path is that of the flange itself: is nozzle_offset set?'
    return f'; the path lies {where_it_lies(capture, points, T_base_camera)}'


def where_it_lies(capture: Capture, points: Array, T_base_camera: Array) -> str:
    """Return in words where path points (N, 3) lie, seen from a camera pose (4, 4)."""
    camera = capture.camera
    x, y, z = np.median(transform(invert(T_base_camera), points), axis=0).tolist()
    if z <= 0:
        return f'{-1e3 * z:.0f} mm behind the camera'
    u, v = camera.pixels(np.array(((x, y, z),)))[0].tolist()
    beyond = {'to the left of': -u, 'to the right of': u - camera.width,
              'above': -v, 'below': v - camera.height}
    side, far = max(beyond.items(), key=lambda item: item[1])
    if far <= 0:
        seen = capture.cloud[..., 2][np.isfinite(capture.cloud[..., 2])]
        if not len(seen):
            return 'where the camera looks, without depth'
        depth = float(np.median(seen))
        return (f'{1e3 * abs(z - depth):.0f} mm {"behind" if z > depth else "in front of"} what '
                'the camera sees')
    return f'{1e3 * far * z / camera.focal_length:.0f} mm {side} what the camera sees'


def _is_at(point: Array, T_base_flange: Array) -> bool:
    return bool(np.linalg.norm(point - T_base_flange[:3, 3]) < AT_FLANGE_M)


def on_cloud(capture: Capture, points: Array, T_base_camera: Array) -> float:
    """Return what share of path points (N, 3) lies on the cloud from a camera pose (4, 4)."""
    points = points[::max(1, len(points) // PROBES)]
    uv = View(capture, T_base_camera).pixels(points)
    seen = np.isfinite(uv).all(axis=1) & capture.camera.contains(uv)
    if not seen.any():
        return 0.0
    depth = transform(invert(T_base_camera), points[seen])[:, 2]
    cloud = sample_cloud(capture.cloud, np.rint(uv[seen]))[:, 2]
    return float(np.count_nonzero(np.abs(cloud - depth) < NEAR_M) / len(points))


def _others(points: Array, hand_eye: HandEye, T_base_camera: Array,
            T_base_flange: Array | None) -> Iterator[tuple[str, Array, Array]]:
    """Yield what else may be meant: in words, the camera's pose (4, 4), and the path (N, 3)."""
    T_parent_camera = hand_eye.T_parent_camera
    T_base_parent = T_base_camera @ invert(T_parent_camera)
    yield 'the inverse of the calibration', T_base_parent @ invert(T_parent_camera), points
    if T_base_flange is None:
        return
    other = T_parent_camera if not hand_eye.on_base else T_base_flange @ T_parent_camera
    yield f'calibration_type {mount_name(not hand_eye.on_base)}', other, points
    if _is_at(points[-1], T_base_flange):
        return
    nozzle = points[-1] - T_base_flange[:3, 3]
    yield 'the nozzle offset of the other sign', T_base_camera, points - 2 * nozzle
    yield 'no nozzle offset', T_base_camera, points - nozzle
