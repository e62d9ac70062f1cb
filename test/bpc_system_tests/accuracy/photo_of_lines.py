"""A bag of a real photo: three panels of ten extruded lines of known geometry.

The photo lies in ``data/fff_pa_lines`` of the folder ``shared`` beside the repository; it has
its own licence and README. Each line was laid from left to right, is 30 mm long and lies 4 mm
above the previous one (lines count from 0 at the bottom). The panels begin at 0, 35 and 70 mm.
A frame surrounds each panel: 4 mm outside the first and last line, and at the ends of the lines.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
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
from bpc_perception.messages.poses.pose import pose_to_message
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.recording.bag_writer import BagWriter
from bpc_system_tests.accuracy.published import beside_repository

PHOTO = Path('shared/data/fff_pa_lines/calibration_control_calibrated.png')
PANEL_STARTS_MM = (0.0, 35.0, 70.0)  # left ends of the panels' lines
LINE_COUNT = 10  # of a panel
LINE_LENGTH_MM, LINE_PITCH_MM = 30.0, 4.0

# The base frame has x along the lines, y from the first line to the last, and z = 0 on the bed.
# The camera was fitted to the photo and that geometry: to the middle between the half-height
# points of the grey-level profile across 12 lines (with the frame) every 10 pixels, and across
# the 6 uprights of the frames every 6 pixels. The 1527 centres lie 0.4 pixels (lines) and
# 0.8 pixels (uprights; root mean square) from where the camera puts them. A free homography is
# no better across the lines, so one camera holds for all panels. The perspective is too weak to
# separate focal length from distance, so fx is chosen. The photo was taken from the side of the
# first line and stretched when it was cut out: pixels are not square.
# Pixels per millimetre at each panel's middle, along and across the lines: 13.5 and 11.4,
# 13.7 and 11.5, 13.9 and 11.5.
IMAGE_SIZE_PX = 1453, 595  # width and height
K = np.array(((1500.0, 0.0, 726.0), (0.0, 1254.18, 297.0), (0.0, 0.0, 1.0)))
CAMERA_POSITION_M = np.array((0.053734578, 0.015112444, 0.109336842))
CAMERA_ORIENTATION = np.array((0.999901, -0.001530, -0.009969, -0.009845))  # x, y, z, w

# What the eye sees in the enlarged photo, with a ruler and without any result drawn in:
# (panel, line) to places, from the line's left end [mm].
# Ink that is certain and without interruption, except where lines meet frames at both ends.
CONTINUOUS = {
    (0, 0): ((1.5, 7.0), (14.0, 29.0)), (0, 1): ((1.5, 7.0), (9.5, 29.0)),
    (0, 2): ((1.5, 29.0),), (0, 3): ((1.5, 29.0),), (0, 4): ((1.5, 29.0),),
    (0, 5): ((1.5, 29.0),), (0, 6): ((1.5, 29.0),), (0, 7): ((1.5, 8.5), (15.5, 20.0)),
    (0, 8): ((1.5, 20.0), (26.0, 29.0)), (0, 9): ((1.5, 20.0), (26.0, 29.0)),
    **{(1, line): ((1.5, 7.2), (14.0, 27.5)) for line in range(10)},
    **{(2, line): ((1.5, 28.5),) for line in range(10)},
}
# Bed, with at most a hair of ink above it: from where the tapering end of the ink has become a
# hair (known to 0.4 mm) to the drop with which the ink begins again.
GAPS = {
    (0, 0): (8.3, 11.0), (1, 0): (8.3, 10.9), (1, 1): (8.3, 11.6), (1, 2): (8.2, 11.5),
    (1, 3): (8.1, 11.4), (1, 4): (8.0, 12.3), (1, 5): (8.1, 11.5), (1, 6): (8.0, 11.3),
    (1, 7): (8.0, 11.3), (1, 8): (7.9, 11.3), (1, 9): (7.9, 11.4),
}
# Lines whose ink bulges to at least twice the width that it has from 14 to 19 mm.
BULGED_LINES = {(0, 0), (0, 1), (0, 2), *((1, line) for line in range(10))}
BULGE_MM = 22.0, 23.5
# Pixels counted across the line between the half-way levels of ink and bed (above) and of ink
# and shadow (below): (panel, line, place [mm]) to width [mm]. Known to a pixel, 0.09 mm.
WIDTHS_MM = {
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
PIXEL_MM = 0.088  # across the lines

# With their frames the lines enclose pores. By panel, those that the eye sees enclosed by ink,
# numbered by the line below (-1 = the frame); those between which a line is torn are one. A hair
# is no ink. Of the left panel's frame the right side is there down to half a millimetre above
# line 3, of the middle panel's to just above line 7, and there all lines are torn.
PORES: tuple[tuple[tuple[int, ...], ...], ...] = (
    ((4,), (5,), (6, 7), (8,), (9,)), (), tuple((line,) for line in range(-1, LINE_COUNT)))
# Of the pore above a line of the right panel: height, the mean of nine places from 3 to 26 mm,
# and length half-way up [mm], between half-way levels read off the grey values of pixels. Each is
# known to half a pixel.
PORE_SIZES_MM = {1: (3.357, 29.31), 5: (3.434, 29.37), 7: (3.431, 29.35)}

START_NS = 1_700_000_000 * 10**9
SPEED_MM_PER_S = 20.0
POSE_RATE_HZ, STATE_RATE_HZ = 100, 50
DWELL_S = 0.2  # standstill at both ends of a line, as while the filament is pulled back


@dataclass(frozen=True)
class Move:
    """A straight move of the nozzle.

    Attributes:
        target: (2,) end of the move [mm].
        duration: shortest duration [s]; longer if the speed asks for it.
        extruding: whether a line is laid.
    """

    target: Array
    duration: float
    extruding: bool


@dataclass(frozen=True)
class Job:
    """The motion of the nozzle, sampled at the rate of the poses.

    Attributes:
        time: (N,) time [s].
        tip: (N, 3) nozzle tip in the base frame [m].
        extruding: (N,) whether a line was being laid.
    """

    time: Array
    tip: Array
    extruding: Array


def find_photo() -> Path | None:
    """Return the photo, or None where it is not beside the repository."""
    return beside_repository(PHOTO)


def camera() -> tuple[PinholeCamera, Array]:
    """Return the fitted camera, and T_base_camera (4, 4)."""
    T_base_camera = np.eye(4)
    T_base_camera[:3, :3] = Rotation.from_quat(CAMERA_ORIENTATION).as_matrix()
    T_base_camera[:3, 3] = CAMERA_POSITION_M
    return PinholeCamera(K, np.zeros(5), *IMAGE_SIZE_PX), T_base_camera


def photo_capture(photo: Path, stamp_ns: int) -> Capture:
    """Return the photo with a cloud that lies exactly on the bed."""
    view, T_base_camera = camera()
    v, u = np.mgrid[0:view.height, 0:view.width]
    rays = np.stack((u, v, np.ones(u.shape)), axis=-1) @ np.linalg.inv(view.K).T
    depth = -T_base_camera[2, 3] / (rays @ T_base_camera[2, :3])
    picture = cv2.imread(str(photo))
    assert picture is not None, f'{photo} is no image'
    image = cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
    return Capture(stamp_ns, 'camera_optical_frame', image.astype(np.uint8),
                   (rays * depth[..., None]).astype(np.float32), view)


def job(frames: bool = False) -> Job:
    """Return all lines one after the other; between them the nozzle passes over bare bed only.

    With ``frames`` these are laid before.
    """
    time, tip, extruding = [0.0], [np.array((PANEL_STARTS_MM[0], 0.0))], [False]
    for move in (*(_frames() if frames else ()), *_moves()):
        distance = float(np.linalg.norm(move.target - tip[-1]))
        time.append(time[-1] + max(distance / SPEED_MM_PER_S, move.duration))
        tip.append(move.target)
        extruding.append(move.extruding)
    sampled = np.arange(int(time[-1] * POSE_RATE_HZ) + 1) / POSE_RATE_HZ
    knots = np.array(tip)
    x, y = (np.interp(sampled, time, knots[:, axis]) for axis in (0, 1))
    arriving = np.clip(np.searchsorted(time, sampled, side='right'), 1, len(time) - 1)
    return Job(sampled, 1e-3 * np.column_stack((x, y, np.zeros(len(x)))),
               np.array(extruding)[arriving])


def _moves() -> Iterator[Move]:
    """Yield all straight moves of the nozzle."""
    for panel in PANEL_STARTS_MM:
        for line in range(LINE_COUNT):
            left, right, y = panel, panel + LINE_LENGTH_MM, LINE_PITCH_MM * line
            yield Move(np.array((left, y)), 0.0, False)
            yield Move(np.array((left, y)), DWELL_S, True)
            yield Move(np.array((right, y)), 0.0, True)
            yield Move(np.array((right, y)), DWELL_S, False)
            if line < LINE_COUNT - 1:  # between two lines, back
                yield Move(np.array((right - 1, y + LINE_PITCH_MM / 2)), 0.0, False)
                yield Move(np.array((left + 1, y + LINE_PITCH_MM / 2)), 0.0, False)
            elif panel != PANEL_STARTS_MM[-1]:  # between two panels, down
                yield Move(np.array((right + 2.5, y)), 0.0, False)
                yield Move(np.array((right + 2.5, -LINE_PITCH_MM)), 0.0, False)
    yield Move(np.array((right, y)), 2.0, False)  # the capture comes after all lines


def _frames() -> Iterator[Move]:
    """Yield the moves of the nozzle that lay the frames, side by side."""
    low, high = -LINE_PITCH_MM, LINE_PITCH_MM * LINE_COUNT
    for left in PANEL_STARTS_MM:
        right = left + LINE_LENGTH_MM
        corners = [np.array(corner) for corner in (
            (left, low), (left, high), (right, high), (right, low), (left, low))]
        yield Move(corners[0], 0.0, False)
        for corner in corners:
            yield Move(corner, DWELL_S, True)
        yield Move(corners[-1], DWELL_S, False)


def write_bag(folder: Path, photo: Path, frames: bool = False) -> tuple[Path, Path]:
    """Record the job with the photo as its only capture; return bag and hand-eye file."""
    laid = job(frames)
    capture_ns = START_NS + round(1e9 * laid.time[-1]) - 10**9
    poses_per_state = POSE_RATE_HZ // STATE_RATE_HZ
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
            if index % poses_per_state == 0:
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
    """Write the camera's pose as easy_handeye2 does."""
    file.write_text(yaml.safe_dump({
        'parameters': {
            'name': 'photo', 'calibration_type': 'eye_on_base', 'robot_base_frame': BASE,
            'robot_effector_frame': 'lbr_link_ee', 'tracking_base_frame': 'camera_optical_frame',
            'tracking_marker_frame': 'marker', 'freehand_robot_movement': True},
        'transform': {
            'translation': dict(zip('xyz', CAMERA_POSITION_M.tolist(), strict=True)),
            'rotation': dict(zip('xyzw', CAMERA_ORIENTATION.tolist(), strict=True))},
    }), encoding='utf-8')
    return file
