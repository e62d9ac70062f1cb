"""A table: columns with their kind and meaning, and rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

# By the end of a column's name.
UNITS = {'_mm': 'mm', '_mm2': 'mm²', '_mm3': 'mm³', '_s': 's'}


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        name: with its unit at the end, in letters, digits and underscores.
        kind: float, int or str.
        meaning: in a few words.
    """

    name: str
    kind: type[float] | type[int] | type[str]
    meaning: str

    @property
    def unit(self) -> str:
        """As the name says; empty = none."""
        return next((unit for end, unit in UNITS.items() if self.name.endswith(end)), '')


@dataclass(frozen=True)
class Table:
    """Rows of which each has a value, or None for not known, for every column.

    Attributes:
        name: as of a variable.
        columns: in order.
        rows: values by names of columns; None or NaN = not known.
    """

    name: str
    columns: Sequence[Column]
    rows: Sequence[Mapping[str, Any]]


LEGEND = (Column('table', str, 'name of the table'), Column('column', str, 'name of the column'),
          Column('unit', str, 'unit; empty = none'), Column('meaning', str, 'what it means'))


def legend(tables: Sequence[Table]) -> Table:
    """Return the table of what the columns of others mean."""
    return Table('legend', LEGEND, [
        {'table': table.name, 'column': column.name, 'unit': column.unit,
         'meaning': column.meaning} for table in tables for column in table.columns])
