"""``bpc batch``: every recording below a folder."""

from __future__ import annotations

from importlib.util import find_spec
import os
from pathlib import Path
from typing import Annotated, Any

import typer

from bpc_perception.cli.parts.options import (
    BaselineOption,
    HandEyeOption,
    JsonOption,
    MatOption,
    ParametersOption,
    QuietOption,
    RemapOption,
    XlsxOption,
)
from bpc_perception.cli.parts.result_table import show_drifts
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.display.plain_text import one_line
from bpc_perception.report.tables.files import chosen_formats, expect_no_others
from bpc_perception.runtime.ros_arguments import remappings

NEEDED_PACKAGES = ('distributed', 'pyarrow')


def batch(
    folder: Annotated[Path, typer.Argument(
        metavar='DIR', help='Folder with recordings in it or below.')],
    out: Annotated[Path, typer.Option(
        '--out', metavar='OUT', help='Folder for the table and a folder of results each.')],
    hand_eye: HandEyeOption = None,
    parameters: ParametersOption = None,
    remap: RemapOption = None,
    workers: Annotated[int | None, typer.Option(
        min=1, metavar='N', help='Processes on this computer; unless given, one for each core.',
    )] = None,
    scheduler: Annotated[str | None, typer.Option(
        metavar='ADDRESS', help='Of a running Dask cluster that sees the same folders, as '
        'tcp://host:8786, instead of this computer\'s cores.')] = None,
    baseline: BaselineOption = None,
    xlsx: XlsxOption = False,
    mat: MatOption = False,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Measure every recording below a folder; what is done already is not done again.

    The exit status is 1 if one of them failed.
    """
    terminal = Terminal(quiet, json_lines)
    if out.exists() and not out.is_dir():
        raise ValueError(f'{out}: expected a folder for the outputs, found a file'
                         '; name another with --out')
    formats = chosen_formats(xlsx, mat)
    expect_no_others(out / 'prints', formats)
    for name in NEEDED_PACKAGES:
        if find_spec(name) is None:
            raise ValueError(f'batch: expected the package {name}, found none'
                             '; install it, as with pip')
    if not folder.is_dir():
        raise ValueError(f'{folder}: expected a folder, found none'
                         '; name the one with the recordings')
    # Imported late: only this command needs a cluster.
    from bpc_perception.batch.cluster import cluster, run
    from bpc_perception.batch.jobs import find_jobs
    from bpc_perception.batch.outputs import groups_of, write_outputs

    jobs = find_jobs(folder, out, hand_eye, parameters, remappings(remap))
    process_count = min(workers or os.cpu_count() or 1, len(jobs))
    with (terminal.progress('batch', len(jobs)) as advance,
          cluster(scheduler, process_count) as client):
        def on_progress(row: dict[str, Any], new: bool) -> None:
            terminal.emit('print', in_words(row, new), **row, measured=new)
            advance()

        rows = run(client, jobs, on_progress)
    groups = groups_of(rows, baseline)
    show_drifts(terminal, groups)
    terminal.files(write_outputs(out, rows, groups, formats))
    name_failures(rows, terminal)


def in_words(row: dict[str, Any], new: bool) -> str:
    """Return a row as a line for people; ``new`` = it was measured now, not before."""
    if row['exit_status']:
        return f'{row["bag"]}: failed'
    mean, std = row['thickness_mean_mm'], row['thickness_std_mm']
    thickness = 'nothing measured' if mean is None else f'{mean:.3f} ± {std:.3f} mm'
    return f'{row["bag"]}: {thickness}' + ('' if new else ', measured before')


def name_failures(rows: list[dict[str, Any]], terminal: Terminal) -> None:
    """Say which recordings failed and why; end the command with exit status 1 if there are any."""
    failed = [row for row in rows if row['exit_status']]
    if not failed:
        return
    terminal.say(f'{len(failed)} of {len(rows)} failed:')
    for row in failed:
        terminal.say(f'  {one_line(row["bag"])}: exit status {row["exit_status"]}: '
                     f'{one_line(row["reason"])}')
    raise typer.Exit(1)
