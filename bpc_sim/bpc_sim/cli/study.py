"""``bpc study``: the paper's tables and figures, and what goes beyond them."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated, Any

from rich.box import SIMPLE_HEAD
from rich.table import Table
import typer

from bpc_perception.cli.parts.options import QuietOption
from bpc_perception.cli.parts.terminal import Terminal


def study(
    name: Annotated[str, typer.Argument(
        help='Which: table1, resolution, thickness, hardware, stress, peers or closedloop.')],
    json_file: Annotated[Path | None, typer.Option(
        '--json', metavar='FILE', help='Write the rows as a list of flat objects.')] = None,
    plot: Annotated[Path | None, typer.Option(
        metavar='FILE.html',
        help='Draw the figure, of resolution, thickness and closedloop.')] = None,
    seeds: Annotated[int | None, typer.Option(
        min=1, metavar='N', help='How many variants of each print; each study has its own '
        'default.')] = None,
    quiet: QuietOption = False,
) -> None:
    """Run a study on simulated prints of known thickness."""
    # The simulator is a package of its own, needed by this command only.
    from bpc_sim.studies import STUDIES

    terminal = Terminal(quiet)
    if name not in STUDIES:
        raise ValueError(f'study: expected one of {", ".join(STUDIES)}, found {name}')
    chosen = STUDIES[name]
    for file in (json_file, plot):
        if file is not None and not file.absolute().parent.is_dir():
            raise ValueError(f'{file}: expected a file in a folder that exists, found none')
    if plot is not None and plot.suffix != '.html':
        raise ValueError(f'{plot}: expected a name that ends in .html')
    if plot is not None and not (chosen.axes or chosen.draw):
        drawn = ', '.join(key for key, other in STUDIES.items() if other.axes or other.draw)
        raise ValueError(f'--plot: expected a study with a figure ({drawn}), found {name}')
    with terminal.progress(name, None) as advance:
        rows = chosen.run(seeds, progress=advance)
    terminal.show(table(chosen.title, rows))
    if json_file is not None:
        json_file.write_text(json.dumps([without_nan(row) for row in rows], indent=2) + '\n')
        terminal.files([json_file])
    if plot is not None:
        from bpc_sim.studies.figures import figure

        page = chosen.draw() if chosen.draw else figure(chosen.title, rows, chosen.axes)
        plot.write_text(page, encoding='utf-8')
        terminal.files([plot])


def table(title: str, rows: list[dict[str, Any]]) -> Table:
    """Rows as a table; few rows with many columns are turned by a quarter."""
    columns = list(dict.fromkeys(column for row in rows for column in row))
    cells = [[in_words(row.get(column, '')) for column in columns] for row in rows]
    turned = len(rows) < len(columns) / 2
    made = Table(title=title, show_header=not turned, box=SIMPLE_HEAD)
    if turned:
        made.add_column('')
        for _ in rows:
            made.add_column('', justify='right', no_wrap=True)
        cells = [[column, *values] for column, *values in zip(columns, *cells, strict=True)]
    else:
        for column, below in zip(columns, zip(*cells, strict=True), strict=True):
            words = column.split('_')  # which may stand above each other, unlike digits
            made.add_column(' '.join(words), justify='right',
                            width=max(map(len, (*words, *below))))
    for values in cells:
        made.add_row(*values)
    return made


def in_words(value: object) -> str:
    """A cell."""
    if not isinstance(value, float):
        return str(value)
    return '-' if math.isnan(value) else f'{value:.3f}'


def without_nan(row: dict[str, Any]) -> dict[str, Any]:
    """A row with null for what is not defined: JSON knows no NaN."""
    return {key: None if isinstance(value, float) and math.isnan(value) else value
            for key, value in row.items()}
