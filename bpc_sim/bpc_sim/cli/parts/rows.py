"""Rows of studies and benchmarks: as a table for people, as JSON for scripts."""

from __future__ import annotations

from collections.abc import Iterable
import json
import math
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from bpc_perception.cli.parts.terminal import Terminal

Row = dict[str, Any]  # flat; units in the names


def check_file(file: Path | None) -> None:
    """Raise ValueError unless a file can be written there; None = no file."""
    if file is not None and not file.absolute().parent.is_dir():
        raise ValueError(f'{file}: expected a file in a folder that exists, found none; make '
                         'the folder')


def write_json(file: Path | None, rows: Iterable[Row], terminal: Terminal) -> None:
    """Write rows as a list of flat objects and name the file; None = no file."""
    if file is not None:
        file.write_text(json.dumps([without_nan(row) for row in rows], indent=2) + '\n')
        terminal.files([file])


def without_nan(row: Row) -> Row:
    """Return a row with None for NaN, which JSON does not know."""
    return {key: None if isinstance(value, float) and math.isnan(value) else value
            for key, value in row.items()}


def table(title: str, rows: list[Row]) -> Table:
    """Return rows as a table, turned by a quarter if there are few rows with many columns."""
    columns = list(dict.fromkeys(column for row in rows for column in row))
    cells = [[in_words(row.get(column, '')) for column in columns] for row in rows]
    if len(rows) < len(columns) / 2:
        return _turned_table(title, columns, cells)
    made = Table(title=title, box=SIMPLE_HEAD)
    for column, below in zip(columns, zip(*cells, strict=True), strict=True):
        words = column.split('_')  # words may be put on lines of their own, unlike digits
        made.add_column(' '.join(words), justify='right', width=max(map(len, (*words, *below))))
    for values in cells:
        made.add_row(*values)
    return made


def _turned_table(title: str, columns: list[str], cells: list[list[str]]) -> Table:
    """Return a table with a line for each column and a column for each row."""
    made = Table(title=title, show_header=False, box=SIMPLE_HEAD)
    made.add_column('')
    for _ in cells:
        made.add_column('', justify='right', no_wrap=True)
    for column, *values in zip(columns, *cells, strict=True):
        made.add_row(column, *values)
    return made


def in_words(value: object) -> str:
    """Return a cell: three digits of a float, a dash for NaN."""
    if not isinstance(value, float):
        return str(value)
    return '-' if math.isnan(value) else f'{value:.3f}'
