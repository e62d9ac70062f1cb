"""Tables as sheets of a workbook of Excel (.xlsx), which other programs open as well."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
import io
import math
import re
from typing import Any

from openpyxl import Workbook
from openpyxl.cell import WriteOnlyCell
from openpyxl.styles import Font
from openpyxl.utils import get_column_letter

from bpc_perception.display.plain_text import table_cell
from bpc_perception.report.tables.table import Table

CREATOR = 'bpc'
MOST_ROWS = 1_048_576  # of a sheet, with its heading [Excel specifications and limits]
MOST_LETTERS = 32_767  # of a cell [the same]
CUT = ' (cut)'
NOT_IN_XML = re.compile('[\ufffe\uffff]')  # beside control characters
NARROWEST, WIDEST = 8, 60  # columns, in letters


def workbook(tables: Sequence[Table]) -> bytes:
    """Return a workbook with a sheet for each table.

    Numbers are numbers, and what is not known is an empty cell. No text is a formula.

    Raises ValueError if a table has more rows than a sheet.
    """
    book = Workbook(write_only=True)  # row by row: a long print has many
    book.properties.creator = CREATOR
    for table in tables:
        if len(table.rows) >= MOST_ROWS:
            raise ValueError(f'{table.name}: expected fewer than {MOST_ROWS} rows for a sheet of '
                             f'Excel, found {len(table.rows)}; leave out --xlsx')
        sheet = book.create_sheet(table.name)
        sheet.freeze_panes = 'A2'
        for number, column in enumerate(table.columns, 1):
            lengths = (len(_text(row[column.name])) for row in table.rows
                       if column.kind is str and row[column.name] is not None)
            width = max(len(column.name) + 2, NARROWEST, *lengths, 0)
            sheet.column_dimensions[get_column_letter(number)].width = min(width, WIDEST)
        heading = [WriteOnlyCell(sheet, column.name) for column in table.columns]
        for cell in heading:
            cell.font = Font(bold=True)
        sheet.append(heading)
        for row in table.rows:
            sheet.append(list(_cells(sheet, table, row)))
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


def _cells(sheet: Any, table: Table, row: Mapping[str, Any]) -> Iterator[Any]:
    for column in table.columns:
        value = row[column.name]
        if value in (None, '') or (isinstance(value, float) and not math.isfinite(value)):
            yield None
        elif column.kind is str:
            cell = WriteOnlyCell(sheet, _text(value))
            cell.data_type = 's'  # also of #N/A, which would be an error
            yield cell
        else:
            yield column.kind(value)


@lru_cache
def _text(value: str) -> str:
    """Return a text that is no formula, neither here nor where the sheet is saved as CSV."""
    text = NOT_IN_XML.sub('?', table_cell(value))
    return text if len(text) <= MOST_LETTERS else text[:MOST_LETTERS - len(CUT)] + CUT
