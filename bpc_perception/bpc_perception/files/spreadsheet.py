"""What spreadsheets of many countries make of CSV: other separators, and decimal commas."""

from __future__ import annotations

from collections.abc import Sequence
import re

SEPARATORS = ',;\t'
DECIMAL_COMMA = re.compile(r'[-+]?\d+,\d+')


def separator_of(lines: Sequence[str]) -> str:
    """Return what is between the cells of a table, by its first line that is not empty."""
    head = next((line for line in lines if line.strip()), '')
    return max(SEPARATORS, key=head.count)


def with_point(cell: str, separator: str) -> str:
    """Return a cell with a decimal point where a spreadsheet wrote a comma."""
    return cell.replace(',', '.') if separator != ',' and DECIMAL_COMMA.fullmatch(cell) else cell
