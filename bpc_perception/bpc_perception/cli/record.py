"""``bpc record``: the suite's topics into a bag."""

from __future__ import annotations

from pathlib import Path
import shutil
import sys
import time
from typing import Annotated

import typer

from bpc_perception.cli.parts.options import JsonOption, QuietOption, RemapOption, remappings
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import RecorderConfig
from bpc_perception.core.parameter import flatten
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.files.parameter_file import configure
from bpc_perception.messages import topics
from bpc_perception.recording.inputs import HAND_EYE, PARAMETERS
from bpc_perception.runtime.signals import exit_on_signal

MB = 1e6  # [bytes]


class Recording:
    """What has been recorded so far, for people to look at."""

    def __init__(self, terminal: Terminal, out: Path) -> None:
        self._terminal, self._out = terminal, out
        self._start = time.monotonic()

    def on_progress(self, counts: dict[str, int], size: int) -> None:
        """Show the messages by topic and the size of the file [bytes]."""
        self._terminal.draw(lambda: self._words(counts, size))

    def _words(self, counts: dict[str, int], size: int) -> str:
        """A line with the rates since the start."""
        passed = time.monotonic() - self._start
        found = {name: sum(count for topic, count in counts.items() if topic.endswith(ending))
                 for name, ending in (('captures', topics.IMAGE), ('profiles', topics.PROFILE))}
        free = shutil.disk_usage(self._out).free
        left = f', full in {free * passed / size / 60:.0f} min' if size > MB else ''
        return (f'{passed:.0f} s: {found["captures"]} captures, {found["profiles"]} profiles, '
                f'{sum(counts.values()) / passed:.0f} messages/s, {size / MB:.0f} MB, '
                f'{size / MB / passed:.1f} MB/s{left}')


def record(
    out: Annotated[Path, typer.Option('--out', metavar='BAG', help='New rosbag2 folder.')],
    hand_eye: Annotated[Path | None, typer.Option(
        '--handeye', metavar='FILE',
        help='Hand-eye calibration, kept with the recording.')] = None,
    parameters: Annotated[Path | None, typer.Option(
        '--params', metavar='FILE', help='ROS parameter file, kept with the recording; '
        'its pose.source says where the poses come from.')] = None,
    remap: RemapOption = None,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Record the suite's topics until Ctrl-C.

    What was recorded is readable even if the recorder is killed. With calibration and parameters
    beside it, it is measured without naming them again.
    """
    terminal = Terminal(quiet, json_lines)
    if out.exists():
        raise ValueError(f'{out}: expected a new bag, found that it exists')
    beside = {}
    if hand_eye is not None:
        load_hand_eye(hand_eye)
        beside[HAND_EYE] = hand_eye.read_bytes()
    pose = configure(RecorderConfig(), 'path_recorder', parameters).pose
    if parameters is not None:
        beside[PARAMETERS] = parameters.read_bytes()
    settings = [part for name, _, value in flatten(pose)
                for part in ('-p', f'pose.{name}:={value}')]
    rules = [part for topic, other in remappings(remap).items()
             for part in ('-r', f'{topic}:={other}')]
    # Imported late: only this command needs ROS set up in this process.
    with exit_on_signal():
        from bpc_perception.nodes import bag_recorder

    level = ['--log-level', 'warn'] if quiet or json_lines else []
    sys.argv = [sys.argv[0], '--ros-args', '--disable-external-lib-logs', '-p', f'bag:={out}',
                *settings, *rules, *level]
    with terminal.view():
        on_progress = Recording(terminal, out).on_progress if terminal.lively else None
        bag_recorder.main(on_progress, beside)
    if json_lines:
        terminal.files([out])
