"""``bpc recover``: a whole recording made from what a torn one still holds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.recording.recovery import recover_bag


def recover(
    bag: Annotated[Path, typer.Argument(
        metavar='BAG', help='A rosbag2 folder, or an .mcap or .db3 file.')],
    out: Annotated[Path, typer.Option('--out', metavar='BAG', help='New rosbag2 folder.')],
) -> None:
    """Write what is readable of a torn recording into a new one, with index and metadata.

    bpc reads torn recordings as they are; this is for programs that do not.
    """
    terminal = Terminal()
    found = recover_bag(bag, out)
    for topic, count in found.messages.items():
        terminal.say(f'{topic}: {count} messages')
    for name in found.left_out:
        terminal.say(f'left out: {name}')
    terminal.files([out])
