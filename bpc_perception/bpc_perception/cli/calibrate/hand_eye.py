"""``bpc calibrate handeye``: the pose of the camera from captures of a board."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from bpc_perception.cli.calibrate.shared import emit_doubt, recorded_poses
from bpc_perception.cli.parts.options import (
    BagArgument,
    JsonOption,
    ParametersOption,
    QuietOption,
    RemapOption,
)
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.board import Board
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.calibration.hand_eye import calibrate, HandEyeCalibration
from bpc_perception.core.calibration.rests import Rest, rests
from bpc_perception.core.calibration.sighting import find_board, Sighting
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import FLANGE, RecorderConfig
from bpc_perception.core.robot.hand_eye import HandEye, MOUNTS
from bpc_perception.display.units import M_PER_MM, MM_PER_M
from bpc_perception.files.hand_eye_file import save_hand_eye
from bpc_perception.files.parameter_file import configure
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.contents import capture_count, captures
from bpc_perception.runtime.ros_arguments import remappings

STANDSTILL_S = 0.3  # how long the flange has to stand for a capture of the board


@dataclass
class BoardCaptures:
    """The captures in which the board was found.

    Attributes:
        poses: (4, 4) T_base_flange at each.
        sightings: where the board was seen in each.
        frame_id: of the camera; empty without captures.
    """

    poses: list[Array] = field(default_factory=list)
    sightings: list[Sighting] = field(default_factory=list)
    frame_id: str = ''


def handeye(
    bag: BagArgument,
    mount: Annotated[str, typer.Option(
        metavar='MOUNT', help='eye_on_base (board on the flange) or eye_in_hand (board fixed).')],
    squares: Annotated[str, typer.Option(
        metavar='CxR', help='Number of squares of the board, as 9x6.')],
    square_mm: Annotated[float, typer.Option(help='Side of a square [mm], as measured.')],
    out: Annotated[Path, typer.Option('--out', metavar='FILE', help='New .calib file.')],
    marker_mm: Annotated[float, typer.Option(
        help='Side of a marker [mm], for a ChArUco board; 0 = checkerboard.')] = 0.0,
    dictionary: Annotated[str, typer.Option(help='Markers of a ChArUco board.')] = 'DICT_4X4_50',
    corners: Annotated[str, typer.Option(
        help='Where the corners are: cloud, or image (by perspective).')] = 'cloud',
    parameters: ParametersOption = None,
    remap: RemapOption = None,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Find the hand-eye calibration from captures of a board.

    Record ten or more captures, the robot standing still at each, with the board seen from
    different sides: turned by 20 degrees or more about different axes.
    """
    terminal = Terminal(quiet, json_lines)
    if mount not in MOUNTS:
        raise ValueError(f'--mount: expected {" or ".join(MOUNTS)}, found {mount!r}'
                         '; say where the camera is')
    if corners not in ('cloud', 'image'):
        raise ValueError(f"--corners: expected cloud or image, found '{corners}'"
                         '; give one of them')
    if out.exists():
        raise ValueError(f'{out}: expected a new file, found that it exists'
                         '; name another with --out')
    board = Board(*board_size(squares), square_mm * M_PER_MM, marker_mm * M_PER_MM, dictionary)
    use_cloud = corners == 'cloud'
    found = find_board_in_all(Bag(bag, remappings(remap)), parameters, board, use_cloud,
                              terminal)
    on_base = MOUNTS[mount]
    result = calibrate(found.poses, found.sightings, on_base, use_cloud)
    scale = float(np.mean([sighting.scale for sighting in found.sightings]))
    show_calibration(terminal, result, len(found.sightings), scale)
    config = configure(RecorderConfig(), 'path_recorder', parameters)
    save_hand_eye(out, HandEye(on_base, result.best.T_parent_camera), out.stem,
                  config.base_frame, FLANGE, found.frame_id or 'camera')
    terminal.files([out])


def board_size(squares: str) -> tuple[int, int]:
    """Return columns and rows of a board such as ``9x6``. Raises ValueError."""
    columns, _, rows = squares.lower().partition('x')
    if not (columns.isdigit() and rows.isdigit()):
        raise ValueError(f'--squares: expected two numbers as 9x6, found {squares!r}'
                         '; count them along both sides')
    return int(columns), int(rows)


def find_board_in_all(bag: Bag, parameters: Path | None, board: Board, use_cloud: bool,
                      terminal: Terminal) -> BoardCaptures:
    """Find the board in the captures of a recording; say which are left out, and why."""
    still = rests(*recorded_poses(bag, parameters), STANDSTILL_S)
    found = BoardCaptures()
    with terminal.progress('look for the board', capture_count(bag)) as advance:
        for number, (_, capture) in enumerate(captures(bag)):
            advance()
            try:
                pose = pose_at_rest(still, capture.stamp_ns)
                sighting = sight_board(capture, board, use_cloud)
            except CalibrationError as error:
                terminal.emit('left_out', f'  capture {number}: left out: {error}',
                              capture=number, reason=str(error))
                continue
            found.poses.append(pose)
            found.sightings.append(sighting)
            found.frame_id = capture.frame_id
    return found


def pose_at_rest(still: list[Rest], stamp_ns: int) -> Array:
    """Return T_base_flange (4, 4) at a time at which the flange stood still.

    Raises:
        CalibrationError: it did not.
    """
    for rest in still:
        if rest.start_ns <= stamp_ns <= rest.end_ns:
            return rest.T_base_flange
    raise CalibrationError('pose: expected the flange to stand still at the capture, found that '
                           'it moves, or no pose'
                           f'; let it stand for {STANDSTILL_S:g} s at each')


def sight_board(capture: Capture, board: Board, use_cloud: bool) -> Sighting:
    """Find the board in a capture.

    Raises:
        CalibrationError: it is not seen, or has no depth where the cloud is used.
    """
    sighting = find_board(capture, board)
    if use_cloud and not sighting.has_depth:
        raise CalibrationError('cloud: expected the board in it, found too few points'
                               '; place it where the camera sees depth, or give --corners image')
    return sighting


def show_calibration(terminal: Terminal, result: HandEyeCalibration, count: int,
                     scale: float) -> None:
    """Show the solutions, the one that is taken, and what makes it doubtful.

    Args:
        terminal: of the command.
        result: all solutions.
        count: number of captures of the board.
        scale: size of the squares in the cloud, relative to the given size; NaN = not known.
    """
    terminal.say(f'{count} captures of the board')
    if np.isfinite(scale):
        terminal.say(f'in the cloud its squares are {scale:.4f} times as large as given')
    terminal.say('method       residual, mm   degrees   camera x, y, z, mm')
    for solution in result.solutions:
        distance, angle = solution.rms
        camera_mm = (solution.T_parent_camera[:3, 3] * MM_PER_M).tolist()
        position = ', '.join(f'{value:.2f}' for value in camera_mm)
        terminal.emit('method', f'{solution.method:12} {distance * MM_PER_M:12.3f} '
                                f'{np.degrees(angle):9.3f}   {position}',
                      method=solution.method, residual_mm=float(distance * MM_PER_M),
                      residual_degrees=float(np.degrees(angle)), camera_mm=camera_mm)
    sigma, angle = result.sigma
    terminal.emit('hand_eye', f'{result.best.method} is taken; uncertainty '
                              f'{sigma * MM_PER_M:.3f} mm, {np.degrees(angle):.3f} degrees',
                  method=result.best.method, captures=count, scale=scale,
                  sigma_mm=float(sigma * MM_PER_M), sigma_degrees=float(np.degrees(angle)))
    for warning in result.warnings:
        emit_doubt(terminal, warning)
