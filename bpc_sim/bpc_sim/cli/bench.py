"""``bpc bench``: speed, verified to be that of right results."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
import json
import os
from pathlib import Path
from typing import Annotated, Any

import typer

from bpc_perception.cli.parts.options import QuietOption
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.recording import inputs
from bpc_sim.cli.study import table, without_nan

TITLES = {
    'core': 'The measurement, beside one blur + Canny + findContours of the same image',
    'bag': 'A recording, offline',
    'live': 'From capture to advice',
    'recorder': 'The path recorder',
}


def bench(
    name: Annotated[str, typer.Argument(help='Which: core, bag, live or recorder.')],
    json_file: Annotated[Path | None, typer.Option(
        '--json', metavar='FILE', help='Write the rows as a list of flat objects.')] = None,
    bag: Annotated[Path | None, typer.Option(
        metavar='BAG', help='Recording to measure, of bag; else the sample.')] = None,
    seconds: Annotated[float, typer.Option(
        min=1, metavar='S', help='How long to print, of live and recorder.')] = 60.0,
    quick: Annotated[bool, typer.Option(
        '--quick', help='The smallest of each only, of core and bag.')] = False,
    quiet: QuietOption = False,
) -> None:
    """Measure speed; what gives wrong results is refused, not timed."""
    terminal = Terminal(quiet)
    if name not in TITLES:
        raise ValueError(f'bench: expected one of {", ".join(TITLES)}, found {name}')
    if json_file is not None and not json_file.absolute().parent.is_dir():
        raise ValueError(f'{json_file}: expected a file in a folder that exists, found none')
    # The simulator is a package of its own, needed by this command only.
    run: Callable[..., list[dict[str, Any]]] = import_module(f'bpc_sim.benchmarks.{name}').run
    sample = Path(os.environ.get('BPC_ROOT', '.')) / 'bags' / 'spiral_gaps'
    with terminal.progress(name, None) as advance:
        chosen: dict[str, Callable[[], list[dict[str, Any]]]] = {
            'core': lambda: run(quick, advance), 'live': lambda: run(seconds, advance),
            'recorder': lambda: run(seconds, advance),
            'bag': lambda: run(inputs.load(bag or sample, None, None), quick, advance)}
        rows = chosen[name]()
    terminal.show(table(TITLES[name], rows))
    if json_file is not None:
        json_file.write_text(json.dumps([without_nan(row) for row in rows], indent=2) + '\n')
        terminal.files([json_file])
