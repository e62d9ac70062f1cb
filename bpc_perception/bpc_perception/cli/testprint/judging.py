"""``bpc testprint judge``: what the recording of a test print tells."""

from __future__ import annotations

from importlib.util import find_spec
from itertools import groupby
import math
from pathlib import Path
from typing import Annotated, Any

from rich.markup import escape
from rich.table import Table
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
from bpc_perception.display.plain_json import plain
from bpc_perception.files import sweep_table
from bpc_perception.files.design.wanted import place_told
from bpc_perception.files.new_files import expect_new, write_new
from bpc_perception.files.testprints.stroke_table import read_test_print
from bpc_perception.recording import inputs
from bpc_perception.report.result_folder import SUMMARY
from bpc_perception.runtime.ros_arguments import remappings

MOST_ROWS = 60  # of a table
LEAST_HZ, LARGEST_HZ = 1.0, 10_000.0
DIGITS = 4  # of a number whose uncertainty is not known


def judge(
    source: Annotated[Path, typer.Argument(
        metavar='RESULT|BAG', help='Folder of a result, or a recording, which is measured '
        'first. How far strands sag is told by a recording alone.')],
    strokes: Annotated[Path, typer.Option(
        '--strokes', metavar='FILE', help='NAME_strokes.csv of the test print, with NAME.csv '
        'beside it.')],
    out: Annotated[Path | None, typer.Option(
        '--out', metavar='DIR', help='Folder for findings.csv, and of lines sweep.csv.')] = None,
    place: Annotated[str, typer.Option(
        '--design-at', metavar='X,Y,Z,YAW', help="Where the bed's corner lies in the robot base "
        'frame [mm] and by how much it is turned about z [degrees]; else it is found from the '
        'path.')] = '',
    state_rate: Annotated[float, typer.Option(
        '--state-hz', metavar='HZ', help='How often the extruder tells its state: lags are right '
        'by half of the time between.')] = 50.0,
    print_number: Annotated[int | None, typer.Option(
        '--print', min=1, metavar='N', help='The print of several that is meant, from 1.')] = None,
    hand_eye: HandEyeOption = None,
    parameters: ParametersOption = None,
    remap: RemapOption = None,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Judge a test print by its result or its recording."""
    terminal = Terminal(quiet, json_lines)
    check_options(state_rate)
    # Imported late: shapely is an extra.
    from bpc_perception.core.testprints.judge import judge as judge_print
    from bpc_perception.report.testprints.rows import FINDINGS_FILE, judgement_files

    test = read_test_print(strokes)
    told = place_told(place) if place else None
    if out is not None:
        expect_new(out, FINDINGS_FILE, *[sweep_table.FILE] * (test.name == 'lines'))
    if (source / SUMMARY).is_file():
        found = read_result(source, print_number)
    else:
        found = measure_print(inputs.load(source, hand_eye, parameters, remappings(remap)),
                              print_number, terminal)
    try:
        judgement = judge_print(test, found.profile, told, found.cloud, 1 / state_rate)
    except ValueError as error:
        raise ValueError(f'{source}: {error}') from error
    show(terminal, judgement)
    if out is not None:
        files = judgement_files(judgement)
        write_new(out, files)
        terminal.files([out / name for name in files])


def check_options(state_rate: float) -> None:
    """Raise ValueError if the rate of states [Hz] is none, or a package is missing."""
    if not LEAST_HZ <= state_rate <= LARGEST_HZ:
        raise ValueError(f'--state-hz: expected {LEAST_HZ:g} to {LARGEST_HZ:g} Hz, found '
                         f'{state_rate:g}; it is the rate of extrusion_state')
    if find_spec('shapely') is None:
        raise ValueError('testprint: expected the package shapely, found none; install it, as '
                         'with pip')


def show(terminal: Terminal, judgement: Any) -> None:
    """Show a Judgement: as tables for people, an event each for scripts."""
    from bpc_perception.report.testprints.rows import finding_row, line_notes, sweep_row

    if judgement.missing:
        numbers = ', '.join(map(str, judgement.missing))
        terminal.warn(f'strokes {numbers}: expected in the print, found none of them there')
    lines = [sweep_row(result) for result in (judgement.sweep.lines if judgement.sweep else ())]
    findings = [finding_row(finding) for finding in judgement.findings]
    notes = [finding_row(finding) for finding in line_notes(judgement)]
    for event, rows in (('line', lines), ('finding', findings + notes)):
        for row in rows:
            terminal.emit(event, '', **plain(row))
    if lines:
        terminal.show(_sweep_table(lines))
    terminal.show(_finding_table(findings[:MOST_ROWS]))
    if len(findings) > MOST_ROWS:
        terminal.say(f'{len(findings) - MOST_ROWS} more: --out and --json have all')
    for of, parts in groupby(notes, key=lambda row: str(row['of'])):
        told = '; '.join(f'{row["quantity"]}: {row["note"]}' for row in parts)
        terminal.say(f'{of}: {told}')


def _sweep_table(rows: list[dict[str, Any]]) -> Table:
    table = Table(*map(escape, ('line', 'flow [mm³/s]', 'speed [mm/s]', 'width [mm]',
                                'height [mm]', 'area [mm²]', 'samples', 'start lag [s]',
                                'stop lag [s]')))
    for row in rows:
        table.add_row(
            str(row['line']), _number(row['flow_mm3_s']), _number(row['speed_mm_s']),
            _number(row['width_mm'], row['width_sigma_mm']),
            _number(row['height_mm'], row['height_sigma_mm']),
            _number(row['area_mm2'], row['area_sigma_mm2']), str(row['samples']),
            _number(row['start_lag_s'], decimals=2), _number(row['stop_lag_s'], decimals=2))
    return table


def _finding_table(rows: list[dict[str, Any]]) -> Table:
    table = Table('of', 'planned', 'quantity', 'value', 'unit', 'samples', '')
    for row in rows:
        at = '' if math.isnan(row['at']) else f'{row["at"]:.4g} {row["at_unit"]}'
        table.add_row(row['of'], at, row['quantity'], _number(row['value'], row['sigma']),
                      row['unit'], str(row['samples']), escape(row['note']))
    return table


def _number(value: float, sigma: float = math.nan, decimals: int | None = None) -> str:
    """Return a number in words, with two digits of its uncertainty; a dash for what is unknown."""
    if math.isnan(value):
        return '-'
    if decimals is None and not sigma > 0:
        return f'{value:.{DIGITS}g}'
    if decimals is None:
        decimals = max(0, 1 - math.floor(math.log10(sigma)))
    return f'{value:.{decimals}f}' + (f' ± {sigma:.{decimals}f}' if sigma > 0 else '')
