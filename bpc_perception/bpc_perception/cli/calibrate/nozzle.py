"""``bpc calibrate nozzle``: the nozzle offset by pivoting."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bpc_perception.cli.calibrate.shared import emit_doubt, recorded_poses
from bpc_perception.cli.parts.options import (
    BagArgument,
    JsonOption,
    ParametersOption,
    QuietOption,
    RemapOption,
)
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.calibration.nozzle import Pivot, pivot
from bpc_perception.core.calibration.rests import Rest, rests
from bpc_perception.display.units import MM_PER_M, S_PER_NS
from bpc_perception.recording.bag import Bag
from bpc_perception.runtime.ros_arguments import remappings

DOUBTFUL_RESIDUAL_M = 0.5e-3


def nozzle(bag: BagArgument, parameters: ParametersOption = None, remap: RemapOption = None,
           quiet: QuietOption = False, json_lines: JsonOption = False) -> None:
    """Find the nozzle offset by pivoting.

    Record the robot while it stands, for two seconds each, in poses that all have the tip in
    one spot, with the flange turned by 20 degrees or more about different axes. The poses may
    be six or more; whatever the robot does between them does not count.
    """
    terminal = Terminal(quiet, json_lines)
    stamps, poses = recorded_poses(Bag(bag, remappings(remap)), parameters)
    still = rests(stamps, poses)
    result = pivot(np.stack([rest.T_base_flange for rest in still]) if still
                   else np.empty((0, 4, 4)))
    terminal.say(f'{len(still)} poses, each stood for a second or more')
    show_poses(still, result, int(stamps[0]), terminal)
    show_offset(result, terminal)
    if result.rms > DOUBTFUL_RESIDUAL_M:
        emit_doubt(terminal, f'the residual is more than {DOUBTFUL_RESIDUAL_M * MM_PER_M:g} mm: '
                             'in one of the poses the tip was not in the spot, or the robot model '
                             'is another')


def show_poses(still: Sequence[Rest], result: Pivot, start_ns: int, terminal: Terminal) -> None:
    """Show when the robot stood in each pose, and how far off the spot the pose puts the tip."""
    for number, (rest, residual) in enumerate(zip(still, result.residuals, strict=True), 1):
        after_s = (rest.start_ns - start_ns) * S_PER_NS
        residual_mm = float(residual * MM_PER_M)
        terminal.emit('pose', f'  {number:2}  after {after_s:6.1f} s   '
                              f'residual {residual_mm:.3f} mm',
                      pose=number, after_s=float(after_s), residual_mm=residual_mm)
    terminal.say(f'residual {result.rms * MM_PER_M:.3f} mm (root mean square)')


def show_offset(result: Pivot, terminal: Terminal) -> None:
    """Show the offset with its uncertainty, and the lines for the parameter file."""
    offset_mm = (result.offset * MM_PER_M).tolist()
    sigma_mm = (result.offset_sigma * MM_PER_M).tolist()
    axes = ', '.join(f'{value:.3f} ± {sigma:.3f}'
                     for value, sigma in zip(offset_mm, sigma_mm, strict=True))
    terminal.emit('nozzle_offset', f'nozzle offset {axes} mm; as a parameter:',
                  offset_mm=offset_mm, sigma_mm=sigma_mm, residual_mm=result.rms * MM_PER_M)
    x, y, z = result.offset.tolist()
    terminal.say('path_recorder:\n  ros__parameters:\n'
                 f'    nozzle_offset: [{x:.6f}, {y:.6f}, {z:.6f}]')
