"""``bpc bench``: speed, verified to be that of right results."""

from __future__ import annotations

from importlib import import_module
import os
from pathlib import Path
from typing import Annotated, Any

import typer

from bpc_perception.cli.parts.options import QuietOption
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.recording import inputs
from bpc_sim.cli.parts.rows import check_file, table, write_json

TITLES = {
    'core': 'The measurement, beside one blur + Canny + findContours of the same image',
    'bag': 'A recording, offline',
    'live': 'From capture to advice',
    'recorder': 'The path recorder',
    'packing': 'Captures packed by record --compress',
    'profiles': 'Profile messages of a long print: the whole, and what changed with a capture',
    'start': 'Commands, beside the mere start of the libraries',
    'setup': 'The first set-up of a copy of this checkout, with empty caches',
}


def bench(
    name: Annotated[str, typer.Argument(
        help='Which: core, bag, live, recorder, packing, profiles, start or setup.')],
    json_file: Annotated[Path | None, typer.Option(
        '--json', metavar='FILE', help='Write the rows as a list of flat objects.')] = None,
    bag: Annotated[Path | None, typer.Option(
        metavar='BAG', help='Recording to measure, of bag and start; else the sample.')] = None,
    seconds: Annotated[float, typer.Option(
        min=1, metavar='S', help='How long to print, of live and recorder.')] = 60.0,
    quick: Annotated[bool, typer.Option(
        '--quick', help='The smallest of each only, of core, bag, packing, profiles, '
        'start.')] = False,
    quiet: QuietOption = False,
) -> None:
    """Measure speed; what gives wrong results is refused, not timed."""
    terminal = Terminal(quiet)
    if name not in TITLES:
        raise ValueError(f'bench: expected one of {", ".join(TITLES)}, found {name}')
    check_file(json_file)
    with terminal.progress(name, None) as advance:
        run = import_module(f'bpc_sim.benchmarks.{name}').run
        rows = run(*benchmark_arguments(name, bag, seconds, quick), advance)
    terminal.show(table(TITLES[name], rows))
    write_json(json_file, rows, terminal)


def benchmark_arguments(name: str, bag: Path | None, seconds: float,
                        quick: bool) -> tuple[Any, ...]:
    """Return what a benchmark of this name is run with."""
    root = Path(os.environ.get('BPC_ROOT', '.'))
    sample = bag or root / 'bags' / 'spiral_gaps'
    match name:
        case 'core' | 'packing' | 'profiles':
            return (quick,)
        case 'bag':
            return inputs.load(sample, None, None), quick
        case 'start':
            return sample, quick
        case 'setup':
            return (root,)
        case _:
            return (seconds,)
