"""``bpc record``: the suite's topics into a bag."""

from __future__ import annotations

from pathlib import Path
import shutil
import sys
import time
from typing import Annotated

import typer

from bpc_perception import topics
from bpc_perception.cli.options import JsonOption, QuietOption, RemapOption, remappings
from bpc_perception.cli.terminal import Terminal

MB = 1e6  # [bytes]


class Recording:
    """What has been recorded so far, for people to look at."""

    def __init__(self, terminal: Terminal, out: Path) -> None:
        self._terminal, self._out = terminal, out
        self._start = time.monotonic()

    def told(self, counts: dict[str, int], size: int) -> None:
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
    remap: RemapOption = None,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Record the suite's topics until Ctrl-C.

    What was recorded is readable even if the recorder is killed.
    """
    terminal = Terminal(quiet, json_lines)
    if out.exists():
        raise ValueError(f'{out}: expected a new bag, found that it exists')
    rules = [part for topic, other in remappings(remap).items()
             for part in ('-r', f'{topic}:={other}')]
    # Imported late: only this command needs ROS set up in this process.
    from bpc_perception.nodes import bag_recorder

    level = ['--log-level', 'warn'] if quiet or json_lines else []
    sys.argv = [sys.argv[0], '--ros-args', '--disable-external-lib-logs', '-p', f'bag:={out}',
                *rules, *level]
    with terminal.view():
        bag_recorder.main(Recording(terminal, out).told if terminal.lively else None)
    if json_lines:
        terminal.files([out])
