"""``bpc measure``: a recorded print measured without a graph."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.cli.parts.design_options import (
    DesignOption,
    InkOffOption,
    InkOnOption,
    PlaceOption,
    with_design,
)
from bpc_perception.cli.parts.options import (
    BagArgument,
    FiguresOption,
    HandEyeOption,
    JsonOption,
    MatOption,
    OutOption,
    ParametersOption,
    QuietOption,
    RemapOption,
    XlsxOption,
)
from bpc_perception.cli.parts.result_table import (
    ResultTable,
    show_layers,
    show_repair,
    show_verdict,
)
from bpc_perception.cli.parts.terminal import Terminal, WARNINGS
from bpc_perception.core.inspection.verdict import PrintVerdict, Verdict
from bpc_perception.display.design_words import design_in_words
from bpc_perception.display.wording import lost_in_words
from bpc_perception.recording import inputs
from bpc_perception.recording.contents import capture_count
from bpc_perception.recording.offline import measure_bag
from bpc_perception.report.outputs import check_figures
from bpc_perception.report.print_results import PrintResults, Wanted
from bpc_perception.report.provenance import provenance_of
from bpc_perception.report.result_folder import check_out, check_recording, replacing
from bpc_perception.report.tables.files import chosen_formats, expect_no_others
from bpc_perception.runtime.exit_status import NOT_ENOUGH_SEEN, NOT_GOOD
from bpc_perception.runtime.ros_arguments import remappings


def measure(
    bag: BagArgument,
    out: OutOption,
    hand_eye: HandEyeOption = None,
    parameters: ParametersOption = None,
    capture: Annotated[int | None, typer.Option(
        min=0, metavar='N',
        help='Report this capture of each print, from 0; else the last.')] = None,
    all_captures: Annotated[bool, typer.Option(
        '--all', help='Write the outputs of every capture, each into its own folder.')] = False,
    print_number: Annotated[int | None, typer.Option(
        '--print', min=1, metavar='N', help='Report this print of the recording alone, from 1; '
        'else all, each in its own folder if there are several.')] = None,
    figures: FiguresOption = False,
    design: DesignOption = None,
    design_at: PlaceOption = '',
    ink_on: InkOnOption = None,
    ink_off: InkOffOption = None,
    verdict: Annotated[bool, typer.Option(
        '--verdict', help='Exit with 3 if a reported print is not good, with 4 if too little of '
        'one is seen.')] = False,
    xlsx: XlsxOption = False,
    mat: MatOption = False,
    remap: RemapOption = None,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Measure a recorded print, to the same digits as live."""
    terminal = Terminal(quiet, json_lines)
    check_out(out)
    check_figures(figures)
    formats = chosen_formats(xlsx, mat)
    expect_no_others(out / 'profile', formats)
    recording = inputs.load(bag, hand_eye, parameters, remappings(remap))
    recording = replace(recording, thickness=with_design(
        recording.thickness, design, design_at, ink_on, ink_off))
    check_recording(out, bag)
    expected, table = capture_count(recording.bag), ResultTable(terminal)
    check_capture(bag, capture, expected)
    with replacing(out) as folder:
        results = PrintResults(
            folder, provenance_of(recording),
            Wanted(capture, all_captures, print_number, figures, formats), expected,
            lambda: WARNINGS.texts)
        with terminal.progress('measure', expected) as advance:
            for result in measure_bag(recording.bag, recording.hand_eye, recording.thickness,
                                      recording.recorder, recording.print_id):
                table.add(result)
                results.add(result)
                advance()
        files = results.finish()
    for result in results.reported:
        if result.profile is not None:
            show_layers(terminal, result.profile)
        if result.verdict is not None:
            show_verdict(terminal, result.verdict)
        if result.repair is not None:
            show_repair(terminal, result.repair)
        if result.design is not None:
            terminal.say(design_in_words(result.design.findings))
    for warning in dict.fromkeys(text for result in results.reported for text in (
            result.warning, lost_in_words(result.profile) if result.profile else '')):
        if warning:
            terminal.warn(warning)
    terminal.files([out / file for file in files])
    if verdict:
        raise typer.Exit(verdict_status(result.verdict for result in results.reported))


def verdict_status(verdicts: Iterable[PrintVerdict | None]) -> int:
    """Return the exit status that tells whether all prints are good."""
    found = {each.verdict for each in verdicts if each is not None}
    if Verdict.FAIL in found:
        return NOT_GOOD
    return NOT_ENOUGH_SEEN if Verdict.NOT_ENOUGH_SEEN in found else 0


def check_capture(bag: Path, wanted: int | None, count: int | None) -> None:
    """Raise ValueError if a recording of so many captures has none of this number.

    A torn recording does not state how many it has: None. Captures that are refused have no
    number, so that a number may turn out to be missing later.
    """
    if wanted is not None and count is not None and wanted >= count:
        numbers = f'one of 0 to {count - 1}' if count else 'none'
        raise ValueError(f'{bag}: expected a capture that it has, found --capture {wanted} of '
                         f'{count}; name {numbers}')
