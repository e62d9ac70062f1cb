"""``bpc compare``: prints beside each other."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from rich.markup import escape
from rich.table import Table
import typer

from bpc_perception.cli.parts.options import (
    BaselineOption,
    JsonOption,
    MatOption,
    QuietOption,
    XlsxOption,
)
from bpc_perception.cli.parts.result_table import show_drifts
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.display.plain_text import one_line
from bpc_perception.report.comparison import cells, COLUMNS, compared_table, load, rows
from bpc_perception.report.control.charts import ChartedPrint, control_groups
from bpc_perception.report.control.tables import control_tables
from bpc_perception.report.pages import comparison_page
from bpc_perception.report.tables.files import chosen_formats, expect_no_others, table_files


def compare(
    folders: Annotated[list[Path], typer.Argument(
        metavar='DIR DIR ...', help='Folders of results: of a print each, or of several.')],
    out: Annotated[Path, typer.Option(
        '--out', metavar='FILE.html', help='The page.')] = Path('compare.html'),
    baseline: BaselineOption = None,
    xlsx: XlsxOption = False,
    mat: MatOption = False,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Compare the results of two or more prints: curves, a table and control charts."""
    terminal = Terminal(quiet, json_lines)
    if out.suffix != '.html' or not out.absolute().parent.is_dir():
        raise ValueError(f'{out}: expected a name that ends in .html in a folder that exists, '
                         'found another; name one with --out')
    formats = chosen_formats(xlsx, mat)
    expect_no_others(out.with_suffix(''), formats)
    prints = load(folders)
    groups = control_groups((ChartedPrint.of(each.name, each.summary) for each in prints),
                            baseline)
    print_rows = rows(prints)
    files = {out.name: comparison_page.render(prints, groups).encode('utf-8', 'replace')}
    files |= table_files(out.stem, (compared_table(print_rows), *control_tables(groups)), formats)
    parts = {out.with_name(name): out.with_name(f'.{name}.part') for name in files}
    for file, part in parts.items():
        part.write_bytes(files[file.name])
    for file, part in parts.items():
        part.replace(file)
    terminal.show(table(print_rows))
    for row in print_rows:
        terminal.emit('print', '', **row)
    show_drifts(terminal, groups)
    terminal.files(parts)


def table(print_rows: list[dict[str, object]]) -> Table:
    """Return a table with a column for each print: usually there are more numbers than prints."""
    headings = ('print', 'verdict', *(column.heading for column in COLUMNS))
    made = Table(show_header=False)
    for line in zip(headings, *map(cells, print_rows), strict=True):
        # Units are in brackets, which rich takes for markup.
        made.add_row(*(escape(one_line(cell)) for cell in line))
    return made
