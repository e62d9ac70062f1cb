"""The folder of each print that is measured live: recording, files and report."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from bpc_perception.cli.parts.monitor import Monitor
from bpc_perception.cli.parts.result_table import show_repair, show_verdict
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import RecorderConfig
from bpc_perception.core.parameter import flatten
from bpc_perception.files.parameter_file import configure
from bpc_perception.recording.print_folder import print_folder
from bpc_perception.report.result_folder import SUMMARY
from bpc_perception.runtime.child_processes import NodeError, Nodes
from bpc_perception.runtime.supervisor import Supervisor

PrintsOption = Annotated[Path, typer.Option(
    '--out', metavar='DIR', help='Folder in which each print gets a folder, named by date and '
    'time, with recording, profile.csv, summary.json and report.html.')]
NoSaveOption = Annotated[bool, typer.Option(
    '--no-save', help='Leave no folder of the print.')]
END_PATIENCE_S = 30.0  # for the last report, on a busy machine


@dataclass(frozen=True)
class SavedPrints:
    """What is needed to keep the prints of a command.

    Attributes:
        folder: in which each print gets a folder.
        hand_eye: calibration with which is measured.
        parameters: ROS parameter file of the nodes; None = none.
        remappings: of topics.
        design: file of the prints' design; None = that of the parameters.
    """

    folder: Path
    hand_eye: Path
    parameters: Path | None = None
    remappings: Mapping[str, str] | None = None
    design: Path | None = None


def recorder_settings(hand_eye: Path | None, parameters: Path | None) -> dict[str, Any]:
    """Return the parameters of a bag recorder that keeps these files with its recordings.

    Raises what ``configure`` raises.
    """
    pose = configure(RecorderConfig(), 'path_recorder', parameters).pose
    return {'hand_eye_file': str(hand_eye or ''), 'parameter_file': str(parameters or ''),
            **{f'pose.{name}': value for name, _, value in flatten(pose)}}


@contextmanager
def saving(saved: SavedPrints | None, monitor: Monitor, terminal: Terminal) -> Iterator[None]:
    """Record each print and write its results while the block runs; say where they are.

    Say first whether each print is good.

    Args:
        saved: what to keep; None = nothing.
        monitor: looks after the nodes that do so, and knows which prints there were.
        terminal: of the command.
    """
    if saved is None:
        yield
        return
    before = _folders(saved.folder)
    try:
        with Nodes(saved.parameters, remappings=saved.remappings,
                   end_patience=END_PATIENCE_S) as nodes:
            nodes.start('bpc_perception.nodes.bag_recorder', prints=str(saved.folder.absolute()),
                        design_file=str(saved.design or ''),
                        **recorder_settings(saved.hand_eye, saved.parameters))
            nodes.start('bpc_perception.nodes.results_writer', prints=str(saved.folder.absolute()),
                        hand_eye_file=str(saved.hand_eye),
                        parameter_file=str(saved.parameters or ''),
                        design_file=str(saved.design or ''))
            monitor.checks.append(_Keeper(Supervisor(nodes, monitor.node), terminal).check)
            yield
    finally:
        measured = {print_folder(saved.folder, print_id) for print_id in monitor.print_ids}
        folders = sorted((_folders(saved.folder) - before)
                         | {folder for folder in measured if folder.is_dir()})
        for verdict in monitor.last_verdicts():
            show_verdict(terminal, verdict.at_its_end(monitor.design_of(verdict.print_id)))
            if (plan := monitor.repairs.get(verdict.stamp_ns)) is not None:
                show_repair(terminal, plan.at_its_end())
        say_what_is_saved(folders, terminal)


def say_what_is_saved(folders: Collection[Path], terminal: Terminal) -> None:
    """Name what is in the folders of prints, and what is not."""
    for folder in folders:
        terminal.files(path for path in sorted(folder.iterdir())
                       if not path.name.startswith('.'))
        if not (folder / SUMMARY).exists():
            terminal.say(f'{folder}: no capture of this print was measured.')
    if not folders:
        terminal.say('Nothing is saved: no print began.')


def _folders(prints: Path) -> set[Path]:
    return {path for path in prints.iterdir() if path.is_dir()} if prints.is_dir() else set()


@dataclass
class _Keeper:
    """Supervises nodes whose end for good is a warning: a print goes on without them."""

    supervisor: Supervisor | None
    terminal: Terminal

    def check(self) -> None:
        try:
            if self.supervisor is not None:
                self.supervisor.check()
        except NodeError as error:
            self.supervisor = None
            self.terminal.warn(f'the print is not saved any more: {error}')
