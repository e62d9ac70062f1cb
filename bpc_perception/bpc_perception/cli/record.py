"""``bpc record``: the suite's topics into a bag."""

from __future__ import annotations

from pathlib import Path
import shutil
import sys
import time
from typing import Annotated

import typer

from bpc_perception.cli.parts.options import JsonOption, QuietOption, RemapOption
from bpc_perception.cli.parts.patient_output import patient_output
from bpc_perception.cli.parts.saved_prints import recorder_settings
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.messages import topics
from bpc_perception.runtime.ros_arguments import remappings, ros_arguments
from bpc_perception.runtime.signals import exit_on_signal

BYTES_PER_MB = 1e6
S_PER_MIN = 60


class RecordingView:
    """What has been recorded so far, as a view in the terminal."""

    def __init__(self, terminal: Terminal, out: Path) -> None:
        self._terminal, self._out = terminal, out
        self._start = time.monotonic()

    def on_progress(self, counts: dict[str, int], size: int) -> None:
        """Show the messages by topic and the size of the recording [bytes]."""
        self._terminal.draw(lambda: self._words(counts, size))

    def _words(self, counts: dict[str, int], size: int) -> str:
        """Return a line with the rates since the start."""
        passed = time.monotonic() - self._start
        captures = sum(count for topic, count in counts.items() if topic.endswith(topics.IMAGE))
        profiles = sum(count for topic, count in counts.items()
                       if topic.endswith((topics.PROFILE, topics.PROFILE_UPDATE)))
        free = shutil.disk_usage(self._out).free
        full_in = (f', full in {free * passed / size / S_PER_MIN:.0f} min' if size > BYTES_PER_MB
                   else '')
        return (f'{passed:.0f} s: {captures} captures, {profiles} profiles, '
                f'{sum(counts.values()) / passed:.0f} messages/s, {size / BYTES_PER_MB:.0f} MB, '
                f'{size / BYTES_PER_MB / passed:.1f} MB/s{full_in}')


def record(
    out: Annotated[Path, typer.Option('--out', metavar='BAG', help='New rosbag2 folder.')],
    hand_eye: Annotated[Path | None, typer.Option(
        '--handeye', metavar='FILE',
        help='Hand-eye calibration, kept with the recording.')] = None,
    parameters: Annotated[Path | None, typer.Option(
        '--params', metavar='FILE', help='ROS parameter file, kept with the recording; '
        'its pose.source says where the poses come from.')] = None,
    compress: Annotated[bool, typer.Option(
        '--compress', help='Pack images and clouds without loss, to less than half. bpc reads '
        'this as it is, and `recover` unpacks it for other programs.')] = False,
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
        raise ValueError(f'{out}: expected a new bag, found that it exists'
                         '; name another with --out')
    if hand_eye is not None:
        load_hand_eye(hand_eye)
    settings = recorder_settings(hand_eye, parameters) | {
        'bag': str(out), 'compress': compress}
    others = remappings(remap)
    # Imported late: only this command needs ROS set up in this process.
    with exit_on_signal():
        from bpc_perception.nodes import bag_recorder

    level = ['--log-level', 'warn'] if quiet or json_lines else []
    sys.argv = [sys.argv[0], *ros_arguments(settings, others), *level]
    with patient_output(), terminal.view():
        on_progress = RecordingView(terminal, out).on_progress if terminal.lively else None
        bag_recorder.main(on_progress)
    if json_lines:
        terminal.files([out])
