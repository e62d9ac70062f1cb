"""``bpc compare``: prints beside each other."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from rich.markup import escape
from rich.table import Table
import typer

from bpc_perception.cli.parts.options import JsonOption, QuietOption
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.report import comparison
from bpc_perception.report.pages import comparison_page


def compare(
    folders: Annotated[list[Path], typer.Argument(
        metavar='DIR DIR ...', help='Folders with profile.csv and summary.json, two or more.')],
    out: Annotated[Path, typer.Option(
        '--out', metavar='FILE.html', help='The page.')] = Path('compare.html'),
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Compare the results of two or more prints: curves and a table."""
    terminal = Terminal(quiet, json_lines)
    if len(folders) < 2:
        raise ValueError('compare: expected two folders or more, found one')
    if out.suffix != '.html' or not out.absolute().parent.is_dir():
        raise ValueError(f'{out}: expected a name that ends in .html in a folder that exists')
    prints = comparison.load(folders)
    page = comparison_page.render(prints).encode('utf-8', 'replace')
    beside = out.with_name(f'.{out.name}.part')
    beside.write_bytes(page)
    beside.replace(out)
    rows = comparison.rows(prints)
    # A column a print: there are more numbers than prints, as a rule.
    headings = ('print', *(column.heading for column in comparison.COLUMNS))
    table = Table(show_header=False)
    for cells in zip(headings, *map(comparison.cells, rows), strict=True):
        table.add_row(*map(escape, cells))  # units are in brackets, as markup is
    terminal.show(table)
    for row in rows:
        terminal.tell('print', '', **row)
    terminal.files([out])
