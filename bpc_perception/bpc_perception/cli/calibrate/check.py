"""``bpc calibrate check``: whether the calibration still holds."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import typer

from bpc_perception.cli.parts.options import (
    BagArgument,
    HandEyeOption,
    JsonOption,
    ParametersOption,
    QuietOption,
    RemapOption,
)
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.calibration.check import (
    Offset,
    offset,
    rough_offset,
    rough_shift,
)
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.result import Result
from bpc_perception.display.units import M_PER_MM, MM_PER_M
from bpc_perception.recording import inputs
from bpc_perception.recording.contents import capture_count
from bpc_perception.recording.offline import measure_bag
from bpc_perception.runtime.ros_arguments import remappings


def check(
    bag: BagArgument,
    hand_eye: HandEyeOption = None,
    parameters: ParametersOption = None,
    tolerance_mm: Annotated[float, typer.Option(
        help='Shift of the camera that is still good [mm].')] = 0.2,
    remap: RemapOption = None,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Tell from a recorded print whether the calibration still holds.

    The exit status is 0 if it does and 1 if it does not or cannot be told.
    """
    terminal = Terminal(quiet, json_lines)
    recording = inputs.load(bag, hand_eye, parameters, remappings(remap))
    measured = measured_offset(recording, terminal)
    holds = measured.holds(tolerance_mm * M_PER_MM)
    show_offset(measured, tolerance_mm, holds, terminal)
    if holds:
        terminal.say(f'OK the calibration holds within {tolerance_mm:g} mm')
        return
    terminal.say(
        f'WARN whether the calibration holds within {tolerance_mm:g} mm cannot be told: print '
        'more' if holds is None else
        f'FAIL the calibration is off by more than {tolerance_mm:g} mm: calibrate the camera, '
        'or the nozzle if that was changed')
    raise typer.Exit(1)


def measured_offset(recording: inputs.Inputs, terminal: Terminal) -> Offset:
    """Return where the bead is seen, relative to the path.

    Ink far beside the path is looked at again with the camera moved by what is seen at once.
    Raises CalibrationError if it cannot be told.
    """
    results = last_results(recording, terminal)
    rough = rough_shift([result.profile for result in results if result.profile is not None])
    poses = [result.T_base_camera for result in results if result.T_base_camera is not None]
    if rough.any() and poses:
        moved = replace(recording, hand_eye=recording.hand_eye.moved(-rough, poses[-1]))
        results = last_results(moved, terminal)
    try:
        found = offset([result.profile for result in results if result.profile is not None])
    except CalibrationError as error:
        if not rough.any():
            raise
        terminal.warn(f'the shift is known roughly only; {error}')
        return rough_offset(rough)
    return replace(found, shift=found.shift + rough)


def last_results(recording: inputs.Inputs, terminal: Terminal) -> list[Result]:
    """Measure a recording; return the last measured result of each print."""
    last = {}
    with terminal.progress('measure', capture_count(recording.bag)) as advance:
        for result in measure_bag(recording.bag, recording.hand_eye, recording.thickness,
                                  recording.recorder):
            advance()
            if result.profile is not None:
                last[result.profile.print_id] = result
    return list(last.values())


def show_offset(measured: Offset, tolerance_mm: float, holds: bool | None,
                terminal: Terminal) -> None:
    """Show where the bead is seen, relative to the path."""
    x, y, z = (measured.shift * MM_PER_M).tolist()
    if measured.samples:
        terminal.say(f'{measured.samples} samples; what is left scatters by '
                     f'{measured.scatter * MM_PER_M:.3f} mm')
    terminal.emit('calibration',
                  f'the bead is seen beside the path by {measured.size * MM_PER_M:.3f} ± '
                  f'{measured.sigma * MM_PER_M:.3f} mm: {x:+.3f}, {y:+.3f}, {z:+.3f} mm in the '
                  'base frame',
                  samples=measured.samples, shift_mm=[x, y, z], size_mm=measured.size * MM_PER_M,
                  sigma_mm=measured.sigma * MM_PER_M, side_mm=measured.side * MM_PER_M,
                  scatter_mm=measured.scatter * MM_PER_M, tolerance_mm=tolerance_mm, holds=holds)
    if measured.samples:
        terminal.say(f'besides, it lies {measured.side * MM_PER_M:+.3f} mm to the left of the '
                     'direction of travel')
