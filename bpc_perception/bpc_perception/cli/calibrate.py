"""``bpc calibrate``: nozzle offset and hand-eye calibration from recordings, and their check."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
import typer

from bpc_perception.cli.parts.options import (
    BagArgument,
    HandEyeOption,
    JsonOption,
    ParametersOption,
    QuietOption,
)
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.board import Board
from bpc_perception.core.calibration.check import offset
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.calibration.hand_eye import calibrate, HandEyeCalibration
from bpc_perception.core.calibration.nozzle import pivot
from bpc_perception.core.calibration.rests import Rest, rests
from bpc_perception.core.calibration.sighting import find_board
from bpc_perception.core.config import FLANGE, RecorderConfig
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.files.hand_eye_file import MOUNTS, save_hand_eye
from bpc_perception.files.parameter_file import configure
from bpc_perception.recording import inputs
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.contents import capture_count, captures, flange_poses
from bpc_perception.recording.offline import measure_bag

POOR_PIVOT = 0.5e-3  # residual from which a pivoting is doubtful [m]
STANDSTILL = 0.3  # how long the flange has to stand for a capture of the board [s]

app = typer.Typer(help='Find the nozzle offset and the hand-eye calibration, and check them.')


@app.command()
def nozzle(bag: BagArgument, parameters: ParametersOption = None, quiet: QuietOption = False,
           json_lines: JsonOption = False) -> None:
    """Find the nozzle offset by pivoting.

    Record the robot while it stands, for two seconds each, in poses that all have the tip in
    one spot, with the flange turned by 20 degrees or more about different axes. The poses may
    be six or more; whatever the robot does between them does not count.
    """
    terminal = Terminal(quiet, json_lines)
    stamps, poses = _poses(Bag(bag), parameters)
    found = rests(stamps, poses)
    result = pivot(np.stack([rest.T_base_flange for rest in found]) if found
                   else np.empty((0, 4, 4)))
    terminal.say(f'{len(found)} poses, each stood for a second or more')
    for number, (rest, residual) in enumerate(zip(found, result.residuals, strict=True), 1):
        after = (rest.start_ns - stamps[0]) * 1e-9
        terminal.tell('pose', f'  {number:2}  after {after:6.1f} s   '
                              f'residual {residual * 1e3:.3f} mm',
                      pose=number, after_s=float(after), residual_mm=float(residual * 1e3))
    terminal.say(f'residual {result.rms * 1e3:.3f} mm (root mean square)')
    x, y, z = result.offset.tolist()
    terminal.tell('nozzle_offset', 'nozzle offset '
                  + ', '.join(f'{value * 1e3:.3f} ± {sigma * 1e3:.3f}' for value, sigma in zip(
                      result.offset, result.offset_sigma, strict=True)) + ' mm; as a parameter:',
                  offset_mm=(result.offset * 1e3).tolist(),
                  sigma_mm=(result.offset_sigma * 1e3).tolist(), residual_mm=result.rms * 1e3)
    terminal.say('path_recorder:\n  ros__parameters:\n'
                 f'    nozzle_offset: [{x:.6f}, {y:.6f}, {z:.6f}]')
    if result.rms > POOR_PIVOT:
        _doubt(terminal, f'the residual is more than {POOR_PIVOT * 1e3:g} mm: in one of the poses '
                         'the tip was not in the spot, or the robot model is another')


@app.command()
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
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Find the hand-eye calibration from captures of a board.

    Record ten or more captures, the robot standing still at each, with the board seen from
    different sides: turned by 20 degrees or more about different axes.
    """
    terminal = Terminal(quiet, json_lines)
    if mount not in MOUNTS:
        raise ValueError(f'--mount: expected {" or ".join(MOUNTS)}, found {mount!r}')
    if corners not in ('cloud', 'image'):
        raise ValueError(f"--corners: expected cloud or image, found '{corners}'")
    if out.exists():
        raise ValueError(f'{out}: expected a new file, found that it exists')
    board = Board(*_size(squares), square_mm * 1e-3, marker_mm * 1e-3, dictionary)
    opened = Bag(bag)
    stamps, poses = _poses(opened, parameters)
    still = rests(stamps, poses, STANDSTILL)
    taken, sightings, frame = [], [], ''
    with terminal.progress('look for the board', capture_count(opened)) as advance:
        for number, (_, capture) in enumerate(captures(opened)):
            advance()
            try:
                pose = _standing(still, capture.stamp_ns)
                sighting = find_board(capture, board)
                if corners == 'cloud' and not sighting.has_depth:
                    raise CalibrationError('cloud: expected the board in it, found too few points')
            except CalibrationError as error:
                terminal.tell('left_out', f'  capture {number}: left out: {error}',
                              capture=number, reason=str(error))
                continue
            taken.append(pose)
            sightings.append(sighting)
            frame = capture.frame_id
    result = calibrate(taken, sightings, MOUNTS[mount], corners == 'cloud')
    _show(terminal, result, len(sightings), float(np.mean([each.scale for each in sightings])))
    config = configure(RecorderConfig(), 'path_recorder', parameters)
    save_hand_eye(out, HandEye(MOUNTS[mount], result.best.T_parent_camera), out.stem,
                  config.base_frame, FLANGE, frame or 'camera')
    terminal.files([out])


@app.command()
def check(
    bag: BagArgument,
    hand_eye: HandEyeOption = None,
    parameters: ParametersOption = None,
    tolerance_mm: Annotated[float, typer.Option(
        help='Shift of the camera that is still good [mm].')] = 0.2,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Tell from a recorded print whether the calibration still holds.

    The exit status is 0 if it does and 1 if it does not or cannot be told.
    """
    terminal = Terminal(quiet, json_lines)
    given = inputs.load(bag, hand_eye, parameters)
    last = {}
    with terminal.progress('measure', capture_count(given.bag)) as advance:
        for result in measure_bag(given.bag, given.hand_eye, given.thickness, given.recorder):
            advance()
            if result.profile is not None:
                last[result.profile.print_id] = result.profile
    found = offset(list(last.values()))
    x, y, z = (found.shift * 1e3).tolist()
    holds = found.holds(tolerance_mm * 1e-3)
    terminal.say(f'{found.samples} samples; what is left scatters by {found.scatter * 1e3:.3f} mm')
    terminal.tell('calibration',
                  f'the bead is seen beside the path by {found.size * 1e3:.3f} ± '
                  f'{found.sigma * 1e3:.3f} mm: {x:+.3f}, {y:+.3f}, {z:+.3f} mm in the base frame',
                  samples=found.samples, shift_mm=[x, y, z], size_mm=found.size * 1e3,
                  sigma_mm=found.sigma * 1e3, side_mm=found.side * 1e3,
                  scatter_mm=found.scatter * 1e3, tolerance_mm=tolerance_mm, holds=holds)
    terminal.say(f'besides, it lies {found.side * 1e3:+.3f} mm to the left of the direction of '
                 'travel')
    if holds:
        terminal.say(f'OK the calibration holds within {tolerance_mm:g} mm')
        return
    terminal.say(
        f'WARN whether the calibration holds within {tolerance_mm:g} mm cannot be told: print '
        'more' if holds is None else
        f'FAIL the calibration is off by more than {tolerance_mm:g} mm: calibrate the camera, '
        'or the nozzle if that was changed')
    raise typer.Exit(1)


def _poses(bag: Bag, parameters: Path | None) -> tuple[NDArray[np.int64], Array]:
    folder = bag.path if bag.path.is_dir() else bag.path.parent
    beside = folder / inputs.PARAMETERS
    config = configure(RecorderConfig(), 'path_recorder',
                       parameters or (beside if beside.exists() else None))
    return flange_poses(bag, config.pose, config.base_frame)


def _standing(still: list[Rest], stamp_ns: int) -> Array:
    """The pose in which the flange stood at a time."""
    for rest in still:
        if rest.start_ns <= stamp_ns <= rest.end_ns:
            return rest.T_base_flange
    raise CalibrationError('pose: expected the flange to stand still at the capture, found that '
                           'it moves, or no pose')


def _size(squares: str) -> tuple[int, int]:
    columns, _, rows = squares.lower().partition('x')
    if not (columns.isdigit() and rows.isdigit()):
        raise ValueError(f'--squares: expected two numbers as 9x6, found {squares!r}')
    return int(columns), int(rows)


def _doubt(terminal: Terminal, text: str) -> None:
    terminal.tell('doubt', f'WARN {text}', text=text)


def _show(terminal: Terminal, result: HandEyeCalibration, count: int, scale: float) -> None:
    terminal.say(f'{count} captures of the board')
    if np.isfinite(scale):
        terminal.say(f'in the cloud its squares are {scale:.4f} times as large as given')
    terminal.say('method       residual, mm   degrees   camera x, y, z, mm')
    for each in result.solutions:
        distance, angle = each.rms
        place = (each.T_parent_camera[:3, 3] * 1e3).tolist()
        position = ', '.join(f'{value:.2f}' for value in place)
        terminal.tell('method', f'{each.method:12} {distance * 1e3:12.3f} '
                                f'{np.degrees(angle):9.3f}   {position}',
                      method=each.method, residual_mm=float(distance * 1e3),
                      residual_degrees=float(np.degrees(angle)), camera_mm=place)
    sigma, angle = result.sigma
    terminal.tell('hand_eye', f'{result.best.method} is taken; uncertainty {sigma * 1e3:.3f} mm, '
                              f'{np.degrees(angle):.3f} degrees',
                  method=result.best.method, captures=count, scale=scale,
                  sigma_mm=float(sigma * 1e3), sigma_degrees=float(np.degrees(angle)))
    for warning in result.warnings:
        _doubt(terminal, warning)
