"""The table of the strokes of a test print: what each is for, a row a stroke.

Whoever prints may fill in the pressure and the temperature, and the flow where it is another.
"""

from __future__ import annotations

from collections.abc import Mapping
import csv
import io
import math
from pathlib import Path

from bpc_perception.core.design.design import DesignError
from bpc_perception.core.testprints.plan import Part, StrokePlan, TestPrint
from bpc_perception.files.design.read import read_design
from bpc_perception.files.spreadsheet import separator_of, with_point

MM, KPA = 1e-3, 1e3
# Of each column: attribute of StrokePlan, and how much one of it is in SI.
UNITS = {
    'flow_mm3_s': ('flow', MM**3), 'speed_mm_s': ('speed', MM), 'lead_in_mm': ('lead_in', MM),
    'run_out_mm': ('run_out', MM), 'distance_mm': ('distance', MM),
    'angle_deg': ('angle', math.pi / 180), 'radius_mm': ('radius', MM),
    'pressure_kpa': ('pressure', KPA), 'temperature_c': ('temperature', 1.0)}
JUDGED = ('judged_from_mm', 'judged_to_mm')
COLUMNS = ('test', 'stroke', 'part', 'nozzle_mm', 'layer_height_mm', 'flow_mm3_s', 'speed_mm_s',
           'lead_in_mm', 'run_out_mm', *JUDGED, 'pair', 'distance_mm', 'angle_deg', 'radius_mm',
           'pressure_kpa', 'temperature_c')
MAY_BE_EMPTY = ('flow_mm3_s', 'distance_mm', 'angle_deg', 'radius_mm', 'pressure_kpa',
                'temperature_c')
SUFFIX = '_strokes.csv'
LARGEST = 1e6
TESTS = ('lines', 'fusion', 'turns', 'lattice', 'line-over-lines', 'wall')


def stroke_table(test: TestPrint) -> str:
    """Return a row for each stroke as CSV with a header; an empty cell = not known, or none."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator='\n')
    writer.writeheader()
    for number, plan in enumerate(test.plans, 1):
        values = {column: getattr(plan, name) / unit for column, (name, unit) in UNITS.items()}
        values |= dict(zip(JUDGED, (place / MM for place in plan.judged), strict=True))
        values |= {'nozzle_mm': test.nozzle / MM, 'layer_height_mm': test.layer_height / MM}
        writer.writerow({'test': test.name, 'stroke': number, 'part': plan.part.value,
                         'pair': plan.pair,
                         **{name: _cell(value) for name, value in values.items()}})
    return text.getvalue()


def _cell(value: float) -> str:
    return '' if math.isnan(value) else f'{value:.6g}'


def read_test_print(file: Path) -> TestPrint:
    """Return the test print whose stroke table this is; its path lies beside it.

    Raises:
        ValueError: one of both is not what was written; the message names what to do.
    """
    if not file.name.endswith(SUFFIX):
        raise ValueError(f'{file}: expected the table of strokes, such as lines{SUFFIX}, found '
                         'another name; name the one that "bpc testprint" wrote')
    rows = _rows(file)
    try:
        tests = {(row['test'], row['nozzle_mm'], row['layer_height_mm']) for row in rows}
        if len(tests) != 1:
            raise ValueError(f'{len(tests)} test prints')
        if rows[0]['test'] not in TESTS:
            raise ValueError(f'the test print {rows[0]["test"]!r}')
        plans = tuple(_plan(row) for row in rows)
        if [int(row['stroke']) for row in rows] != list(range(1, len(rows) + 1)):
            raise ValueError('strokes with other numbers than 1, 2, 3, ...')
        nozzle, height = (_value(rows[0], name) * MM for name in ('nozzle_mm', 'layer_height_mm'))
    except (KeyError, ValueError) as error:
        raise ValueError(f'{file}: expected the strokes of a test print, found {error}'
                         '; correct it, or write it anew') from error
    path = file.with_name(file.name.removesuffix(SUFFIX) + '.csv')
    try:
        return TestPrint(rows[0]['test'], nozzle, height, read_design(path), plans)
    except DesignError as error:
        raise ValueError(f'{error}; keep the path beside its stroke table') from error


def _rows(file: Path) -> list[Mapping[str, str]]:
    """Return the rows of a table, also as a spreadsheet saves it. Raises ValueError."""
    try:
        lines = file.read_text('utf-8-sig').splitlines()
        separator = separator_of(lines)
        reader = csv.DictReader(lines, delimiter=separator)
        rows: list[Mapping[str, str]] = [
            {name: with_point(cell, separator) if isinstance(cell, str) else cell
             for name, cell in row.items()} for row in reader]
        found = tuple(reader.fieldnames or ())
    except (OSError, csv.Error, UnicodeDecodeError) as error:
        raise ValueError(f'{file}: expected a readable stroke table, found: {error}'
                         '; name another') from error
    if set(COLUMNS) - set(found) or not rows or any(
            None in row or None in row.values() for row in rows):
        lacking = ', '.join(sorted(set(COLUMNS) - set(found))) or 'other rows'
        raise ValueError(f'{file}: expected a row for each stroke with the columns of a stroke '
                         f'table, found {lacking} wrong; save it as CSV in UTF-8, or write it '
                         'anew')
    return rows


def _plan(row: Mapping[str, str]) -> StrokePlan:
    """Return what a row tells. Raises KeyError, ValueError."""
    values = {name: _value(row, column) * unit for column, (name, unit) in UNITS.items()}
    begin, end = (_value(row, name) * MM for name in JUDGED)
    if not values['speed'] > 0 or values['flow'] <= 0 or begin > end or values['lead_in'] < 0 \
            or values['run_out'] < 0:
        raise ValueError(f'no possible flow, speed or place in stroke {row["stroke"]}')
    return StrokePlan(Part(row['part']), judged=(begin, end), pair=int(row['pair']), **values)


def _value(row: Mapping[str, str], column: str) -> float:
    cell = row[column].strip()
    if not cell and column in MAY_BE_EMPTY:
        return math.nan
    value = float(cell)
    if not abs(value) <= LARGEST:
        raise ValueError(f'{column} {cell}')
    return value
