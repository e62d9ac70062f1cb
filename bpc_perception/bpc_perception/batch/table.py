"""The tables of a batch: a row for each print, as CSV and Parquet."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pyarrow
from pyarrow import csv, parquet

from bpc_perception.display.plain_text import table_cell
from bpc_perception.report.control.tables import moment
from bpc_perception.report.entries import design_numbers
from bpc_perception.report.tables.table import Column, Table

TEXTS = {'print_id': 'identifier of the print', 'method': 'method of measurement',
         'hand_eye': 'hand-eye calibration',
         'fingerprint': 'changes whenever something that the result is made of does'}
COUNTS = {'capture': 'number of the capture reported', 'samples': 'its samples',
          'gap_count': 'its gaps'}
NUMBERS = {
    'path_length_mm': 'length of the path', 'thickness_mean_mm': 'mean thickness',
    'thickness_std_mm': 'standard deviation of the thickness',
    'thickness_q1_mm': 'first quartile of the thickness',
    'thickness_median_mm': 'median thickness',
    'thickness_q3_mm': 'third quartile of the thickness',
    'thickness_variation': 'standard deviation by mean',
    'within_10_percent': 'share of the known path within 10 % of the target or the median',
    'coverage': 'share of the samples of strokes that are measured or a gap',
    'gap_length_mm': 'length of all gaps', 'offset_mean_mm': 'mean offset from the path',
    'offset_rms_mm': 'root mean square of the offset'}
COLUMNS = (
    Column('bag', str, 'the recording'),
    Column('exit_status', int, 'what bpc measure would have ended with'),
    Column('reason', str, 'why it was not measured'),
    Column('results', str, 'folder of its results'),
    *(Column(name, str, meaning) for name, meaning in TEXTS.items()),
    *(Column(name, int, meaning) for name, meaning in COUNTS.items()),
    Column('captures', int, 'number of captures'),
    Column('refused_captures', int, 'number of captures refused'),
    Column('warnings', str, 'warnings, separated by semicolons'),
    *(Column(name, float, meaning) for name, meaning in NUMBERS.items()),
    Column('print', int, 'number of the print in its recording, from 1'),
    Column('ooze_count', int, 'stretches of ink on travel'),
    Column('ooze_length_mm', float, 'their length'),
    Column('verdict', str, 'PASS, FAIL or NOT_ENOUGH_SEEN'),
    Column('defects', int, 'number of defects'),
    Column('time', str, 'time of the capture that is reported, UTC'),
    Column('height_mean_mm', float, 'mean height'),
    Column('design_off_mm', float, 'how far the middle of the deposit is from the design, 95 %'),
    Column('layer_fidelity', float, 'share of the design to which ink is near'))
TYPES = {str: pyarrow.string(), int: pyarrow.int64(), float: pyarrow.float64()}


def row(name: str, out: Path, number: int, summary: dict[str, Any]) -> dict[str, Any]:
    """Return the row of a print, from 1, of a recording that was measured."""
    captures = summary['captures']
    return {'bag': name, 'exit_status': 0, 'reason': '', 'results': str(out),
            **{key: summary[key] for key in (
                *TEXTS, *COUNTS, *NUMBERS, 'ooze_count', 'ooze_length_mm')},
            'verdict': summary['verdict']['verdict'],
            'defects': len(summary['verdict']['defects']),
            'print': number, 'captures': len(captures),
            'refused_captures': sum('refusal' in capture for capture in captures),
            'warnings': '; '.join(summary['warnings']), 'time': moment(summary['stamp_ns']),
            'height_mean_mm': summary['ink']['height_mean_mm'], **design_numbers(summary)}


def failed(name: str, status: int, reason: str) -> dict[str, Any]:
    """Return the row of a recording that was not measured, with the exit status and the reason."""
    return {**dict.fromkeys(column.name for column in COLUMNS), 'bag': name,
            'exit_status': status, 'reason': ' '.join(reason.split())}


def prints_table(rows: list[dict[str, Any]]) -> Table:
    """Return the table of prints from its rows."""
    return Table('prints', COLUMNS, rows)


def csv_and_parquet(table: Table) -> Iterator[tuple[str, bytes]]:
    """Yield name and content of a table as CSV and as Parquet.

    Programs for spreadsheets open the first, so no cell of it is a formula.
    """
    schema = pyarrow.schema([(column.name, TYPES[column.kind]) for column in table.columns])
    cells = [{name: table_cell(value) if isinstance(value, str) else value
              for name, value in row.items()} for row in table.rows]
    for suffix, rows, write in (
            ('csv', cells, csv.write_csv),
            ('parquet', [_unicode(row) for row in table.rows], parquet.write_table)):
        stream = pyarrow.BufferOutputStream()
        write(pyarrow.Table.from_pylist(rows, schema), stream)
        yield f'{table.name}.{suffix}', stream.getvalue().to_pybytes()


def _unicode(row: Any) -> dict[str, Any]:
    """Return a row whose texts are valid Unicode, which a file name need not be."""
    return {name: value.encode('utf-8', 'replace').decode() if isinstance(value, str) else value
            for name, value in row.items()}
