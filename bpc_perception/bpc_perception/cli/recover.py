"""``bpc recover``: a whole recording made from what a torn one still holds."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
import shutil
from typing import Annotated

import typer

from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.recording import mcap_file
from bpc_perception.recording.atomic import atomic_bag
from bpc_perception.recording.bag import Bag, BagError
from bpc_perception.recording.inputs import KEPT_BESIDE


def recover(
    bag: Annotated[Path, typer.Argument(metavar='BAG', help='A rosbag2 folder or .mcap file.')],
    out: Annotated[Path, typer.Option('--out', metavar='BAG', help='New rosbag2 folder.')],
) -> None:
    """Write what is readable of a torn recording into a new one, with index and metadata.

    bpc reads torn recordings as they are; this is for programs that do not.
    """
    terminal = Terminal()
    files = Bag(bag).files
    if any(file.suffix != '.mcap' for file in files):
        raise BagError(f'{bag}: expected a recording in MCAP files, found sqlite3'
                       '; bpc measures it as it is')
    counts = copy_messages(files, out)
    for name in KEPT_BESIDE if bag.is_dir() else ():
        if (files[0].parent / name).exists():
            shutil.copy(files[0].parent / name, out)
    for topic, count in counts.items():
        terminal.say(f'{topic}: {count} messages')
    terminal.files([out])


def copy_messages(files: list[Path], out: Path) -> Counter[str]:
    """Copy all readable messages of MCAP files into a new bag; return their number by topic."""
    counts: Counter[str] = Counter()
    with atomic_bag(out) as writer:
        for file in files:
            for message in mcap_file.messages(file):
                if message.topic not in counts:
                    writer.add_topic(message.topic, message.type_name, message.definition)
                writer.write(message.topic, message.log_ns, message.data)
                counts[message.topic] += 1
    return counts
