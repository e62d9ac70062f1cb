"""A design as a table of points."""

from __future__ import annotations

import csv
import math

import numpy as np

from bpc_perception.core.config import LARGEST_TARGET_M, LEAST_TARGET_M
from bpc_perception.core.design.design import Design, DesignError, DesignStroke, FARTHEST_M
from bpc_perception.files.design.refusals import refusal

MM = 1e-3
NEEDED, OPTIONAL = ('x_mm', 'y_mm', 'z_mm'), ('stroke', 'width_mm', 'layer', 'tool')
LARGEST_NUMBER = 1_000_000  # of a stroke, a layer or a tool
Row = tuple[int, dict[str, float]]  # number of its line, and its values


def design_from_table(text: str) -> Design:
    """Return the design in a CSV file with the columns x_mm, y_mm and z_mm, in any order.

    ``stroke`` numbers the strokes, and is 0 where the nozzle travels; without it all is one
    stroke. ``width_mm`` is that from the row before to this one; empty = not told. ``layer`` and
    ``tool`` count from 0. Raises DesignError.
    """
    rows = _rows(text)
    strokes = []
    first = 0
    for index in range(1, len(rows) + 1):
        if index == len(rows) or _kind(rows[index]) != _kind(rows[first]):
            if _kind(rows[first])[0] > 0:
                strokes.append(_stroke(rows[first:index]))
            first = index
    if not strokes:
        raise DesignError('expected rows of a stroke, found travel alone; number the strokes '
                          'from 1')
    return Design(tuple(strokes))


def _kind(row: Row) -> tuple[int, int, int]:
    """Return what is the same in all rows of a stroke: its number, layer and tool."""
    _, values = row
    return int(values['stroke']), int(values['layer']), int(values['tool'])


def _rows(text: str) -> list[Row]:
    """Return the rows below the names of the columns."""
    reader = csv.reader(text.splitlines())
    try:
        names = [name.strip().lower() for name in next(reader, [])]
        unknown = [name for name in names if name not in NEEDED + OPTIONAL]
        if unknown or not set(NEEDED) <= set(names) or len(set(names)) < len(names):
            raise refusal(1, f'the columns {",".join(NEEDED)}, and maybe {",".join(OPTIONAL)}',
                          ','.join(names)[:60] or 'nothing', 'correct its first line')
        rows = [(reader.line_num, _values(names, row, reader.line_num))
                for row in reader if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise refusal(reader.line_num, 'a table as CSV', str(error), 'save it as that') from error
    if not rows:
        raise DesignError('expected rows of points, found none; write two at least')
    return rows


def _values(names: list[str], row: list[str], line: int) -> dict[str, float]:
    """Return the values of a row, with what is not told."""
    if len(row) != len(names):
        raise refusal(line, f'{len(names)} values', f'{len(row)}', 'correct it')
    values = {'stroke': 1.0, 'width_mm': math.nan, 'layer': 0.0, 'tool': 0.0}
    for name, cell in zip(names, row, strict=True):
        if cell.strip() or name in NEEDED:
            values[name] = _value(name, cell, line)
    return values


def _value(name: str, cell: str, line: int) -> float:
    """Return the value of a cell."""
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if name in NEEDED:
        if not abs(value) * MM <= FARTHEST_M:
            raise refusal(line, f'a coordinate within {FARTHEST_M / MM:g} mm as {name}',
                          repr(cell[:40]), 'correct it')
    elif name == 'width_mm':
        if not LEAST_TARGET_M <= value * MM <= LARGEST_TARGET_M:
            raise refusal(line, f'a width from {LEAST_TARGET_M / MM:g} to '
                          f'{LARGEST_TARGET_M / MM:g} mm', repr(cell[:40]),
                          'is it in millimetres? Leave it empty if it is not known')
    elif not (0 <= value <= LARGEST_NUMBER and value == int(value)):
        raise refusal(line, f'a whole number from 0 as {name}', repr(cell[:40]), 'correct it')
    return value


def _stroke(rows: list[Row]) -> DesignStroke:
    """Return the stroke through rows that are all of it."""
    line, values = rows[0]
    points = MM * np.array([[row[name] for name in NEEDED] for _, row in rows])
    widths = MM * np.array([row['width_mm'] for _, row in rows[1:]])
    moved = np.diff(points, axis=0).any(axis=1)
    if not moved.any():
        raise refusal(line, 'a stroke through two points or more', 'one point', 'add others, or '
                      'make it travel, stroke 0')
    return DesignStroke(points[np.append(True, moved)], widths[moved],
                        int(values['layer']), int(values['tool']), line)
