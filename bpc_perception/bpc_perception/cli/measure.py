"""``bpc measure``: a recorded print measured without a graph."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.cli.parts.options import (
    BagArgument,
    FiguresOption,
    HandEyeOption,
    JsonOption,
    OutOption,
    ParametersOption,
    QuietOption,
)
from bpc_perception.cli.parts.result_table import ResultTable
from bpc_perception.cli.parts.terminal import Terminal, WARNINGS
from bpc_perception.core.session import Result
from bpc_perception.recording import inputs
from bpc_perception.recording.contents import capture_count
from bpc_perception.recording.offline import measure_bag
from bpc_perception.report.outputs import check_figures, check_out, write_outputs
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.provenance import provenance_of


def measure(
    bag: BagArgument,
    out: OutOption,
    hand_eye: HandEyeOption = None,
    parameters: ParametersOption = None,
    capture: Annotated[int | None, typer.Option(
        metavar='N', help='Report this capture of the print, from 0; else the last.')] = None,
    all_captures: Annotated[bool, typer.Option(
        '--all', help='Write the outputs of every capture, each into its own folder.')] = False,
    figures: FiguresOption = False,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Measure a recorded print, to the same digits as live."""
    terminal = Terminal(quiet, json_lines)
    check_out(out)
    check_figures(figures)
    recording = inputs.load(bag, hand_eye, parameters)
    expected = capture_count(recording.bag)
    table, log = ResultTable(terminal), PrintLog(capture, expected)
    with terminal.progress('measure', expected) as advance:
        for result in measure_bag(recording.bag, recording.hand_eye, recording.thickness,
                                  recording.recorder):
            table.add(result)
            log.add(result)
            if all_captures and result.profile is not None:
                write_outputs(out / f'capture_{result.profile.capture:04d}',
                              PrintLog.of([result]), provenance_of(recording), figures)
            advance()
    result = reported_result(log, bag)
    if result.warning:
        terminal.warn(result.warning)
    log.warnings = list(WARNINGS.texts)
    terminal.files(write_outputs(out, log, provenance_of(recording), figures))


def reported_result(log: PrintLog, bag: Path) -> Result:
    """Return the result that is reported.

    Raises:
        ValueError: no capture was measured, or not the one that is wanted.
    """
    if not log.numbers:
        reasons = '; '.join(sorted(log.refusals)) or 'no capture'
        raise ValueError(f'{bag}: expected a capture that can be measured, found: {reasons}')
    if log.reported is None:
        raise ValueError(f'{bag}: expected capture {log.wanted}, '
                         f'found {", ".join(map(str, log.numbers))}')
    return log.reported
