"""A bag of a real photo: three panels of ten extruded lines, their geometry known.

The photo lies in ``data/fff_pa_lines`` of the folder ``shared`` beside the repository; it has
a licence and a README of its own. Each line was laid from left to right, 30 mm long and 4 mm
above the one before (lines count from 0 at the bottom); the panels begin at 0, 35 and 70 mm.
A frame 4 mm outside the first and last line, at the lines' ends, surrounds each panel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
import os
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import Rotation
import yaml

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.config import BASE
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.pose import pose_to_message
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.recording.bag_writer import BagWriter

PHOTO = Path('shared/data/fff_pa_lines/calibration_control_calibrated.png')
PANELS = (0.0, 35.0, 70.0)  # left ends of the panels' lines [mm]
LINES = 10
LENGTH, PITCH = 30.0, 4.0  # [mm]

# The base frame has x along the lines, y from the first line to the last and z = 0 on the bed.
# The camera was fitted to the photo and that geometry: to the middle between the half-height
# points of the grey-level profile across 12 lines (frame included) every 10 pixels, and across
# the 6 uprights of the frames every 6 pixels. The 1527 centres found lie 0.4 pixels (lines) and
# 0.8 pixels (uprights; root mean square) from where the camera has them; a free homography does
# no better across the lines, so that one camera holds for all panels. As the perspective is too
# slight to tell focal length from distance, fx is chosen. The photo was taken from the side of
# the first line, and stretched by whoever cut it out: hence pixels that are not square.
# Pixels a millimetre at each panel's middle, along and across the lines: 13.5 and 11.4,
# 13.7 and 11.5, 13.9 and 11.5.
SIZE = 1453, 595  # width and height [pixels]
K = np.array(((1500.0, 0.0, 726.0), (0.0, 1254.18, 297.0), (0.0, 0.0, 1.0)))
CAMERA_POSITION = np.array((0.053734578, 0.015112444, 0.109336842))  # [m]
CAMERA_ORIENTATION = np.array((0.999901, -0.001530, -0.009969, -0.009845))  # x, y, z, w

# What the eye sees in the enlarged photo, a ruler beside it and no result drawn in: (panel, line)
# to where, from the line's left end [mm].
# Ink without interruption or doubt, without the first and last bit where lines meet frames.
CONTINUOUS = {
    (0, 0): ((1.5, 7.0), (14.0, 29.0)), (0, 1): ((1.5, 7.0), (9.5, 29.0)),
    (0, 2): ((1.5, 29.0),), (0, 3): ((1.5, 29.0),), (0, 4): ((1.5, 29.0),),
    (0, 5): ((1.5, 29.0),), (0, 6): ((1.5, 29.0),), (0, 7): ((1.5, 8.5), (15.5, 20.0)),
    (0, 8): ((1.5, 20.0), (26.0, 29.0)), (0, 9): ((1.5, 20.0), (26.0, 29.0)),
    **{(1, line): ((1.5, 7.2), (14.0, 27.5)) for line in range(10)},
    **{(2, line): ((1.5, 28.5),) for line in range(10)},
}
# Bed, with at most a hair above it, from where the tapering end of the ink has become a hair,
# good to 0.4 mm, to the drop with which the ink begins again.
GAPS = {
    (0, 0): (8.3, 11.0), (1, 0): (8.3, 10.9), (1, 1): (8.3, 11.6), (1, 2): (8.2, 11.5),
    (1, 3): (8.1, 11.4), (1, 4): (8.0, 12.3), (1, 5): (8.1, 11.5), (1, 6): (8.0, 11.3),
    (1, 7): (8.0, 11.3), (1, 8): (7.9, 11.3), (1, 9): (7.9, 11.4),
}
# Where ink bulges to at least twice its width from 14 to 19 mm.
BULGES = {(0, 0), (0, 1), (0, 2), *((1, line) for line in range(10))}
BULGE = 22.0, 23.5
# Pixels counted across the line between the half-way levels of ink and bed (above) and of ink
# and shadow (below): (panel, line, place [mm]) to width [mm]. Good to a pixel, 0.09 mm.
WIDTHS = {
    (0, 0, 15.0): 0.47, (0, 0, 22.7): 1.23, (0, 1, 4.0): 0.52, (0, 1, 15.0): 0.45,
    (0, 1, 22.7): 1.15, (0, 2, 15.0): 0.47, (0, 4, 26.0): 0.49, (0, 5, 15.0): 0.49,
    (0, 7, 4.0): 0.48, (0, 7, 17.0): 0.36, (0, 8, 8.7): 0.75, (0, 8, 15.0): 0.41,
    (1, 0, 4.0): 0.61, (1, 0, 15.0): 0.49, (1, 1, 22.7): 1.27, (1, 1, 27.0): 0.61,
    (1, 2, 18.0): 0.50, (1, 3, 15.0): 0.43, (1, 5, 4.0): 0.46, (1, 5, 15.0): 0.44,
    (1, 5, 22.7): 1.27, (1, 6, 27.0): 0.50, (1, 8, 15.0): 0.42, (1, 8, 22.7): 1.25,
    (1, 9, 4.0): 0.43,
    (2, 0, 5.0): 0.72, (2, 0, 26.0): 0.76, (2, 2, 15.0): 0.61, (2, 3, 21.0): 0.53,
    (2, 5, 15.0): 0.54, (2, 8, 4.0): 0.49, (2, 8, 15.0): 0.55, (2, 8, 26.0): 0.57,
}
PIXEL = 0.088  # across the lines [mm]

START_NS = 1_700_000_000 * 10**9
SPEED = 20.0  # [mm/s]
POSE_RATE, STATE_RATE = 100, 50  # [Hz]
DWELL = 0.2  # standstill at a line's start and end, as while the filament is pulled back [s]


@dataclass(frozen=True)
class Job:
    """The nozzle's way, sampled at the poses' rate.

    Attributes:
        time: (N,) [s].
        tip: (N, 3) nozzle tip in the base frame [m].
        extruding: (N,) whether a line was being laid.
    """

    time: Array
    tip: Array
    extruding: Array


def find_photo() -> Path | None:
    """The photo, where the folder that holds it is there."""
    here = os.environ.get('BPC_ROOT', Path(__file__).resolve().parents[3])
    photo = Path(here).parent / PHOTO
    return photo if photo.is_file() else None


def camera() -> tuple[PinholeCamera, Array]:
    """The fitted camera, and T_base_camera (4, 4)."""
    T_base_camera = np.eye(4)
    T_base_camera[:3, :3] = Rotation.from_quat(CAMERA_ORIENTATION).as_matrix()
    T_base_camera[:3, 3] = CAMERA_POSITION
    return PinholeCamera(K, np.zeros(5), *SIZE), T_base_camera


def photo_capture(photo: Path, stamp_ns: int) -> Capture:
    """The photo with a cloud that lies on the bed exactly."""
    view, T_base_camera = camera()
    v, u = np.mgrid[0:view.height, 0:view.width]
    rays = np.stack((u, v, np.ones(u.shape)), axis=-1) @ np.linalg.inv(view.K).T
    depth = -T_base_camera[2, 3] / (rays @ T_base_camera[2, :3])
    picture = cv2.imread(str(photo))
    assert picture is not None, f'{photo} is no image'
    image = cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
    return Capture(stamp_ns, 'camera_optical_frame', image.astype(np.uint8),
                   (rays * depth[..., None]).astype(np.float32), view)


def job() -> Job:
    """All lines one after the other; between them the nozzle passes over bare bed only."""
    time, tip, extruding = [0.0], [np.array((PANELS[0], 0.0))], [False]
    for target, pause, on in _moves():
        distance = float(np.linalg.norm(target - tip[-1]))
        time.append(time[-1] + max(distance / SPEED, pause))
        tip.append(target)
        extruding.append(on)
    sampled = np.arange(int(time[-1] * POSE_RATE) + 1) / POSE_RATE
    knots = np.array(tip)
    x, y = (np.interp(sampled, time, knots[:, axis]) for axis in (0, 1))
    arriving = np.clip(np.searchsorted(time, sampled, side='right'), 1, len(time) - 1)
    return Job(sampled, 1e-3 * np.column_stack((x, y, np.zeros(len(x)))),
               np.array(extruding)[arriving])


def _moves() -> Iterator[tuple[Array, float, bool]]:
    """Where to go in a straight line [mm], for how long at least [s], laying a line or not."""
    for panel in PANELS:
        for line in range(LINES):
            left, right, y = panel, panel + LENGTH, PITCH * line
            yield np.array((left, y)), 0.0, False
            yield np.array((left, y)), DWELL, True
            yield np.array((right, y)), 0.0, True
            yield np.array((right, y)), DWELL, False
            if line < LINES - 1:  # between two lines, back
                yield np.array((right - 1, y + PITCH / 2)), 0.0, False
                yield np.array((left + 1, y + PITCH / 2)), 0.0, False
            elif panel != PANELS[-1]:  # between two panels, down
                yield np.array((right + 2.5, y)), 0.0, False
                yield np.array((right + 2.5, -PITCH)), 0.0, False
    yield np.array((right, y)), 2.0, False  # the capture comes after all lines


def write_bag(folder: Path, photo: Path) -> tuple[Path, Path]:
    """Record the job, then the photo as its one capture; the bag and the hand-eye file."""
    laid = job()
    capture_ns = START_NS + round(1e9 * laid.time[-1]) - 10**9
    every = POSE_RATE // STATE_RATE
    pending = list(zip(topics.CAMERA, capture_to_messages(photo_capture(photo, capture_ns)),
                       strict=True))
    with BagWriter(folder / 'bag') as bag:
        for name, kind in (topics.CAMERA | topics.PRINT).items():
            bag.add_topic(f'/{name}', topics.type_name(kind))
        flange = np.eye(4)
        for index, (time, tip) in enumerate(zip(laid.time.tolist(), laid.tip, strict=True)):
            stamp_ns = START_NS + round(1e9 * time)
            flange[:3, 3] = tip
            bag.write(f'/{topics.POSE}', stamp_ns, pose_to_message(stamp_ns, BASE, flange))
            if index % every == 0:
                state = ExtrusionState(
                    extruding=bool(laid.extruding[index]), plunger_velocity=float('nan'),
                    plunger_position=float('nan'), flow_rate=float('nan'))
                state.header.stamp = ns_to_stamp(stamp_ns)
                bag.write(f'/{topics.EXTRUSION}', stamp_ns, state)
            while pending and stamp_ns >= capture_ns:
                name, message = pending.pop(0)
                bag.write(f'/{name}', stamp_ns, message)
    return folder / 'bag', write_hand_eye(folder / 'photo.calib')


def write_hand_eye(file: Path) -> Path:
    """The camera's pose as easy_handeye2 writes it."""
    file.write_text(yaml.safe_dump({
        'parameters': {
            'name': 'photo', 'calibration_type': 'eye_on_base', 'robot_base_frame': BASE,
            'robot_effector_frame': 'lbr_link_ee', 'tracking_base_frame': 'camera_optical_frame',
            'tracking_marker_frame': 'marker', 'freehand_robot_movement': True},
        'transform': {
            'translation': dict(zip('xyz', CAMERA_POSITION.tolist(), strict=True)),
            'rotation': dict(zip('xyzw', CAMERA_ORIENTATION.tolist(), strict=True))},
    }), encoding='utf-8')
    return file
