"""``bpc window``: which settings give the width that is wanted, learnt from a sweep."""

from __future__ import annotations

from importlib.util import find_spec
import math
from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.cli.parts.options import JsonOption, QuietOption
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import LARGEST_TARGET_M, LEAST_TARGET_M, ToleranceConfig
from bpc_perception.core.window.sweep import SweepLine
from bpc_perception.display.units import M_PER_MM, MM_PER_M
from bpc_perception.files.settings_file import settings_file
from bpc_perception.files.sweep_table import COLDEST_C, HOTTEST_C, KELVIN, read_sweep
from bpc_perception.report.outputs import check_figures

LARGEST_SPEED_MM_S = 1e4


def window(
    results: Annotated[list[Path], typer.Argument(
        metavar='RESULT ...', help='Sweeps of one ink: folders with sweep.csv, or such tables.')],
    target: Annotated[float, typer.Option(
        '--target-mm', metavar='MM', help='Width wanted.')],
    tolerance: Annotated[float, typer.Option(
        '--tolerance', metavar='SHARE', help='How far a width may be off it, as a share.',
    )] = ToleranceConfig.width,
    speed: Annotated[float, typer.Option(
        '--speed-mm-s', metavar='MM/S', help='Speed of the nozzle; the best unless given.',
    )] = math.nan,
    temperature: Annotated[float, typer.Option(
        '--temperature-c', metavar='C', help='Temperature of the ink, one of those in the sweep; '
        'that of most lines unless given.')] = math.nan,
    out: Annotated[Path | None, typer.Option(
        '--out', metavar='DIR', help='Folder for window.html, window.csv, window.json and '
        'next_print.yaml.')] = None,
    parameters: Annotated[Path | None, typer.Option(
        '--params', metavar='FILE', help='ROS parameter file whose values next_print.yaml '
        'keeps.')] = None,
    figures: Annotated[bool, typer.Option(
        '--figures', help='Also write a figure for papers, PDF and SVG, into DIR.')] = False,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Find the settings that give a width, from a sweep of flow or pressure and speed."""
    terminal = Terminal(quiet, json_lines)
    check_options(target, tolerance, speed, temperature)
    check_files(out, figures, parameters)
    lines = read_all(results)
    # Imported late: statsmodels is an extra, and is slow to load.
    from bpc_perception.cli.window.tables import show
    from bpc_perception.core.window.assess import find_window
    from bpc_perception.core.window.window import Wanted
    from bpc_perception.report.window.files import check_out, write

    sources = [str(result.resolve()) for result in results]
    if out is not None:
        check_out(out, sources)
    found = find_window(lines, Wanted(target * M_PER_MM, tolerance, speed * M_PER_MM,
                                      temperature + KELVIN))
    show(terminal, found)
    if out is not None:
        terminal.files(write(out, found, sources, parameters, figures))


def read_all(results: list[Path]) -> list[SweepLine]:
    """Return the lines of all sweeps, in their order. Raises ValueError."""
    if len({result.resolve() for result in results}) < len(results):
        raise ValueError('expected each sweep once, found one twice; name each once')
    names = [f'{result.name} ' if len(results) > 1 else '' for result in results]
    return [line for result, name in zip(results, names, strict=True)
            for line in read_sweep(result, name)]


def check_options(target: float, tolerance: float, speed: float, temperature: float) -> None:
    """Raise ValueError if a number cannot be meant.

    Args:
        target: width wanted [mm].
        tolerance: as a share.
        speed: of the nozzle [mm/s]; NaN = not given.
        temperature: of the ink [°C]; NaN = not given.
    """
    least, largest = LEAST_TARGET_M * MM_PER_M, LARGEST_TARGET_M * MM_PER_M
    if not least <= target <= largest:
        raise ValueError(f'--target-mm: expected {least:g} to {largest:g} mm, found {target:g}; '
                         'is it in millimetres?')
    if not 0 < tolerance < 1:
        raise ValueError(f'--tolerance: expected a share between 0 and 1, found {tolerance:g}; '
                         'write 0.1 for 10 %')
    if not math.isnan(speed) and not 0 < speed <= LARGEST_SPEED_MM_S:
        raise ValueError(f'--speed-mm-s: expected up to {LARGEST_SPEED_MM_S:g} mm/s, found '
                         f'{speed:g}; is it in millimetres per second?')
    if not math.isnan(temperature) and not COLDEST_C <= temperature <= HOTTEST_C:
        raise ValueError(f'--temperature-c: expected {COLDEST_C:g} to {HOTTEST_C:g} °C, found '
                         f'{temperature:g}; is it in degrees Celsius?')


def check_files(out: Path | None, figures: bool, parameters: Path | None) -> None:
    """Raise ValueError if options do not go together, or there is nothing to do it with."""
    for given, name in ((figures, '--figures'), (parameters is not None, '--params')):
        if given and out is None:
            raise ValueError(f'{name}: expected a folder for files, found none; name one with '
                             '--out')
    check_figures(figures)
    settings_file({}, LEAST_TARGET_M, ToleranceConfig.width, parameters)
    if find_spec('statsmodels') is None:
        raise ValueError('window: expected the package statsmodels, found none; install it, as '
                         'with pip')
