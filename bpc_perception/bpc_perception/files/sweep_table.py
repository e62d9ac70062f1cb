"""The lines of a sweep as a table, which ``bpc testprint`` or a spreadsheet writes."""

from __future__ import annotations

import csv
import math
from pathlib import Path

from bpc_perception.core.window.sweep import SweepLine
from bpc_perception.files.spreadsheet import separator_of, with_point

FILE = 'sweep.csv'
LARGEST_FILE_BYTES = 1_000_000
MM, KELVIN = 1e-3, 273.15
# By column: the attribute of a line, and the factor to SI units.
NUMBERS = {
    'flow_mm3_s': ('flow', 1e-9), 'speed_mm_s': ('speed', MM), 'pressure_kpa': ('pressure', 1e3),
    'temperature_c': ('temperature', 1.0), 'width_mm': ('width', MM),
    'width_sigma_mm': ('width_sigma', MM), 'height_mm': ('height', MM),
    'height_sigma_mm': ('height_sigma', MM), 'area_mm2': ('area', MM**2),
    'area_sigma_mm2': ('area_sigma', MM**2), 'samples': ('', 1.0),
    'start_lag_s': ('start_lag', 1.0), 'stop_lag_s': ('stop_lag', 1.0)}
COLUMNS = ('line', *NUMBERS)
NEEDED = ('speed_mm_s', 'width_mm')
DRIVES = ('flow_mm3_s', 'pressure_kpa')
MAY_BE_NOUGHT = ('temperature_c', 'samples', 'start_lag_s', 'stop_lag_s')
LARGEST = 1e6  # of any number
COLDEST_C, HOTTEST_C = -50.0, 400.0


class SweepTableError(ValueError):
    """A table is not what was expected; the message names file and line."""


def read_sweep(source: Path, name: str = '') -> list[SweepLine]:
    """Return the lines of a sweep.

    Columns may be in any order, and all but speed, width, and flow or pressure may be missing. An
    empty cell = not known. Commas, semicolons or tabs are between cells, and decimal commas in
    them where these are not.

    Args:
        source: the table, or a folder with FILE.
        name: put before the name of each line.

    Raises SweepTableError.
    """
    file = source / FILE if source.is_dir() else source
    try:
        return [_line(name, number, cells) for number, cells in _rows(_text(file))]
    except _CellError as error:
        raise SweepTableError(f'{file}, {error}') from None


class _CellError(Exception):
    """What is wrong in a line, with its number, but not the file."""

    def __init__(self, line: int, expected: str, found: str, what_to_do: str) -> None:
        super().__init__(f'line {line}: expected {expected}, found {found}; {what_to_do}')


def _text(file: Path) -> str:
    try:
        with file.open('rb') as stream:
            content = stream.read(LARGEST_FILE_BYTES + 1)
    except OSError as error:
        raise SweepTableError(f'{file}: expected a table of a sweep, found: {error.strerror}; '
                              'name a CSV file, or a folder with '
                              f'{FILE}') from error
    if len(content) > LARGEST_FILE_BYTES:
        raise SweepTableError(f'{file}: expected a table of a sweep, found more than '
                              f'{LARGEST_FILE_BYTES} bytes; is it the right file?')
    try:
        return content.decode('utf-8-sig')
    except UnicodeDecodeError as error:
        line = content[:error.start].count(b'\n') + 1
        raise SweepTableError(f'{file}, line {line}: expected text in UTF-8, found other bytes; '
                              'save it as "CSV UTF-8"') from error


def _rows(text: str) -> list[tuple[int, dict[str, str]]]:
    """Return the rows below the names of the columns, each with the number of its line."""
    lines = text.splitlines()
    separator = separator_of(lines)
    reader = csv.reader(lines, delimiter=separator)
    names: list[str] = []
    rows = []
    try:
        for cells in reader:
            cells = [cell.strip() for cell in cells]
            if not any(cells):
                continue
            if not names:
                names = _names(cells)
            elif len(cells) != len(names):
                raise _CellError(reader.line_num, f'{len(names)} cells', str(len(cells)),
                                 'leave a cell empty for what is not known')
            else:
                rows.append((reader.line_num, {
                    key: with_point(cell, separator)
                    for key, cell in zip(names, cells, strict=True)}))
    except csv.Error as error:
        raise _CellError(reader.line_num, 'a table as CSV', str(error),
                         'save it as that') from error
    if not names:
        raise _CellError(1, 'the names of the columns', 'nothing', f'write {",".join(COLUMNS)}')
    if not rows:
        raise _CellError(2, 'a row for each line', 'none', 'add them')
    return rows


def _names(cells: list[str]) -> list[str]:
    names = [cell.lower() for cell in cells]
    unknown = [name or 'one without a name' for name in names if name not in COLUMNS]
    doubled = [name for name in names if names.count(name) > 1]
    missing = [name for name in NEEDED if name not in names]
    if not set(DRIVES) & set(names):
        missing.append(' or '.join(DRIVES))
    if unknown:
        raise _CellError(1, f'columns of {",".join(COLUMNS)}', unknown[0][:40],
                         'correct or remove it')
    if doubled:
        raise _CellError(1, 'each column once', f'{doubled[0]} twice', 'remove one')
    if missing:
        raise _CellError(1, f'the column {missing[0]}', 'none', 'add it')
    return names


def _line(name: str, number: int, cells: dict[str, str]) -> SweepLine:
    """Return the line that a row tells of."""
    values = {key: _value(key, cell, number) for key, cell in cells.items() if key != 'line'}
    if math.isnan(values['speed_mm_s']):
        raise _CellError(number, 'a speed', 'none', 'add speed_mm_s, or remove the row')
    if math.isfinite(temperature := values.get('temperature_c', math.nan)):
        values['temperature_c'] = temperature + KELVIN
    label = cells.get('line') or f'in row {number}'
    return SweepLine(f'{name}line {label}', **{
        NUMBERS[key][0]: value * NUMBERS[key][1] for key, value in values.items()
        if NUMBERS[key][0]})


def _value(key: str, cell: str, number: int) -> float:
    """Return the value of a cell; NaN where it is empty."""
    if not cell:
        return math.nan
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not abs(value) <= LARGEST:
        raise _CellError(number, f'a number as {key}', repr(cell[:40]),
                         'correct it, or leave it empty if it is not known')
    if key == 'temperature_c' and not COLDEST_C <= value <= HOTTEST_C:
        raise _CellError(number, f'{COLDEST_C:g} to {HOTTEST_C:g} °C as {key}', cell[:40],
                         'correct it')
    if key in MAY_BE_NOUGHT:
        return value
    if value <= 0:
        raise _CellError(number, f'a number above 0 as {key}', cell[:40],
                         'leave it empty if it is not known, or if the line is not there')
    return value
