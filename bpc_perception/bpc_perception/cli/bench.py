"""``bpc bench``: speed, verified to be that of right results."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import import_module
import json
import os
from pathlib import Path
from typing import Annotated, Any

import typer

from bpc_perception.cli import inputs
from bpc_perception.cli.study import show, without_nan

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
) -> None:
    """Measure speed; what gives wrong results is refused, not timed."""
    if name not in TITLES:
        raise ValueError(f'bench: expected one of {", ".join(TITLES)}, found {name}')
    if json_file is not None and not json_file.absolute().parent.is_dir():
        raise ValueError(f'{json_file}: expected a file in a folder that exists, found none')
    # The simulator is a package of its own, needed by this command only.
    run: Callable[..., list[dict[str, Any]]] = import_module(f'bpc_sim.benchmarks.{name}').run
    chosen = {'core': partial(run, quick), 'live': partial(run, seconds),
              'recorder': partial(run, seconds)}
    if name == 'bag':
        sample = Path(os.environ.get('BPC_ROOT', '.')) / 'bags' / 'spiral_gaps'
        rows = run(inputs.load(bag or sample, None, None), quick)
    else:
        rows = chosen[name]()
    show(TITLES[name], rows)
    if json_file is not None:
        json_file.write_text(json.dumps([without_nan(row) for row in rows], indent=2) + '\n')
        print(json_file)
