"""``bpc compare``: prints beside each other."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from rich.markup import escape
from rich.table import Table
import typer

from bpc_perception.cli.parts.options import JsonOption, QuietOption
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.display.plain_text import one_line
from bpc_perception.report.comparison import cells, COLUMNS, load, rows
from bpc_perception.report.pages import comparison_page


def compare(
    folders: Annotated[list[Path], typer.Argument(
        metavar='DIR DIR ...', help='Folders of results: of a print each, or of several.')],
    out: Annotated[Path, typer.Option(
        '--out', metavar='FILE.html', help='The page.')] = Path('compare.html'),
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Compare the results of two or more prints: curves and a table."""
    terminal = Terminal(quiet, json_lines)
    if out.suffix != '.html' or not out.absolute().parent.is_dir():
        raise ValueError(f'{out}: expected a name that ends in .html in a folder that exists, '
                         'found another; name one with --out')
    prints = load(folders)
    page = comparison_page.render(prints).encode('utf-8', 'replace')
    beside = out.with_name(f'.{out.name}.part')
    beside.write_bytes(page)
    beside.replace(out)
    print_rows = rows(prints)
    terminal.show(table(print_rows))
    for row in print_rows:
        terminal.emit('print', '', **row)
    terminal.files([out])


def table(print_rows: list[dict[str, object]]) -> Table:
    """Return a table with a column for each print: usually there are more numbers than prints."""
    headings = ('print', 'verdict', *(column.heading for column in COLUMNS))
    made = Table(show_header=False)
    for line in zip(headings, *map(cells, print_rows), strict=True):
        # Units are in brackets, which rich takes for markup.
        made.add_row(*(escape(one_line(cell)) for cell in line))
    return made
