"""``bpc study``: the paper's tables and figures, and what goes beyond them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

from rich.console import Console
from rich.table import Table
import typer


def study(
    name: Annotated[str, typer.Argument(help='Which study: table1.')],
    json_file: Annotated[Path | None, typer.Option(
        '--json', metavar='FILE', help='Write the rows as a list of flat objects.')] = None,
) -> None:
    """Run a study on simulated prints of known thickness."""
    # The simulator is a package of its own, needed by this command only.
    from bpc_sim.studies import STUDIES

    if name not in STUDIES:
        raise ValueError(f'study: expected one of {", ".join(STUDIES)}, found {name}')
    if json_file is not None and not json_file.absolute().parent.is_dir():
        raise ValueError(f'{json_file}: expected a file in a folder that exists, found none')
    title, rows = STUDIES[name]()
    table = Table(title=title)
    for column in rows[0]:
        table.add_column(column, justify='right', no_wrap=True)
    for row in rows:
        table.add_row(*(f'{value:.3f}' if isinstance(value, float) else str(value)
                        for value in row.values()))
    # Rather wider than the terminal than with numbers cut short.
    Console(width=max(Console().width, 240)).print(table)
    if json_file is not None:
        json_file.write_text(json.dumps(rows, indent=2) + '\n')
        print(json_file)
