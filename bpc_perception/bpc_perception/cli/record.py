"""``bpc record``: the suite's topics into a bag."""

from __future__ import annotations

from pathlib import Path
import sys
from typing import Annotated

import typer

from bpc_perception.cli.options import RemapOption, remappings


def record(
    out: Annotated[Path, typer.Option('--out', metavar='BAG', help='New rosbag2 folder.')],
    remap: RemapOption = None,
) -> None:
    """Record the suite's topics until Ctrl-C.

    What was recorded is readable even if the recorder is killed.
    """
    if out.exists():
        raise ValueError(f'{out}: expected a new bag, found that it exists')
    rules = [part for topic, other in remappings(remap).items()
             for part in ('-r', f'{topic}:={other}')]
    # Imported late: only this command needs ROS set up in this process.
    from bpc_perception.nodes import bag_recorder

    sys.argv = [sys.argv[0], '--ros-args', '--disable-external-lib-logs', '-p', f'bag:={out}',
                *rules]
    bag_recorder.main()
