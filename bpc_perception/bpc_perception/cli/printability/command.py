"""``bpc printability``: how well an ink prints, in the numbers that laboratories report."""

from __future__ import annotations

from importlib.util import find_spec
import math
from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.cli.parts.options import (
    HandEyeOption,
    JsonOption,
    ParametersOption,
    QuietOption,
    RemapOption,
)
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.cli.printability.measured_print import measure_print, read_result
from bpc_perception.display.units import M_PER_MM
from bpc_perception.recording import inputs
from bpc_perception.report.outputs import check_figures
from bpc_perception.report.result_folder import SUMMARY
from bpc_perception.runtime.ros_arguments import remappings

LEAST_NOZZLE_MM, LARGEST_NOZZLE_MM = 0.01, 20.0


def printability(
    source: Annotated[Path, typer.Argument(
        metavar='RESULT|BAG', help='Folder of a result, or a recording, which is measured '
        'first.')],
    out: Annotated[Path | None, typer.Option(
        '--out', metavar='DIR', help='Folder for printability.csv.')] = None,
    nozzle: Annotated[float, typer.Option(
        '--nozzle-mm', metavar='MM', help='Inner diameter of the nozzle; not known unless '
        'given.')] = math.nan,
    print_number: Annotated[int | None, typer.Option(
        '--print', min=1, metavar='N', help='The print of several that is meant, from 1.')] = None,
    figures: Annotated[bool, typer.Option(
        '--figures', help='Also write a figure of the pores for papers, PDF and SVG, into '
        'DIR.')] = False,
    hand_eye: HandEyeOption = None,
    parameters: ParametersOption = None,
    remap: RemapOption = None,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Tell pores, uniformity, fusion and more of a print."""
    terminal = Terminal(quiet, json_lines)
    check_options(nozzle, out, figures)
    # Imported late: shapely is an extra.
    from bpc_perception.cli.printability.tables import show
    from bpc_perception.core.printability.assess import assess, Conditions
    from bpc_perception.report.printability.files import check_out, write

    if (source / SUMMARY).is_file():
        found = read_result(source, print_number)
    else:
        found = measure_print(inputs.load(source, hand_eye, parameters, remappings(remap)),
                              print_number, terminal)
    profile = found.profile
    if not (profile.stroke > 0).any():
        raise ValueError(f'{source}: expected a print with ink, found no stroke; choose another')
    if out is not None:
        check_out(out, profile.print_id)
    result = assess(profile, Conditions(nozzle * M_PER_MM, found.target, found.cloud))
    show(terminal, result, profile.print_id)
    if out is not None:
        terminal.files(write(out, result, profile.print_id, figures))


def check_options(nozzle: float, out: Path | None, figures: bool) -> None:
    """Raise ValueError if options do not go together, or there is nothing to do it with.

    Args:
        nozzle: inner diameter [mm]; NaN = not given.
        out: folder for files; None = none are wanted.
        figures: whether figures are wanted.
    """
    if not math.isnan(nozzle) and not LEAST_NOZZLE_MM <= nozzle <= LARGEST_NOZZLE_MM:
        raise ValueError(f'--nozzle-mm: expected {LEAST_NOZZLE_MM:g} to {LARGEST_NOZZLE_MM:g} mm, '
                         f'found {nozzle:g}; is it in millimetres?')
    if figures and out is None:
        raise ValueError('--figures: expected a folder for them, found none; name one with --out')
    check_figures(figures)
    if find_spec('shapely') is None:
        raise ValueError('printability: expected the package shapely, found none; install it, as '
                         'with pip')

