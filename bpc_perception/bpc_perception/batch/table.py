"""The table of a batch: a row for each print, as prints.csv and prints.parquet."""

from __future__ import annotations

import os
from pathlib import Path
import tempfile
from typing import Any

import pyarrow
from pyarrow import csv, parquet

from bpc_perception.display.plain_text import table_cell

NUMBER_COLUMNS = (
    'path_length_mm', 'thickness_mean_mm', 'thickness_std_mm', 'thickness_q1_mm',
    'thickness_median_mm', 'thickness_q3_mm', 'thickness_variation', 'within_10_percent',
    'coverage', 'gap_length_mm', 'offset_mean_mm', 'offset_rms_mm')
COUNT_COLUMNS = ('capture', 'samples', 'gap_count')
TEXT_COLUMNS = ('print_id', 'method', 'hand_eye', 'fingerprint')
SCHEMA = pyarrow.schema([
    ('bag', pyarrow.string()), ('exit_status', pyarrow.int32()), ('reason', pyarrow.string()),
    ('results', pyarrow.string()), *((name, pyarrow.string()) for name in TEXT_COLUMNS),
    *((name, pyarrow.int64()) for name in COUNT_COLUMNS), ('captures', pyarrow.int64()),
    ('refused_captures', pyarrow.int64()), ('warnings', pyarrow.string()),
    *((name, pyarrow.float64()) for name in NUMBER_COLUMNS), ('print', pyarrow.int64()),
    ('ooze_count', pyarrow.int64()), ('ooze_length_mm', pyarrow.float64()),
    ('verdict', pyarrow.string()), ('defects', pyarrow.int64())])


def row(name: str, out: Path, number: int, summary: dict[str, Any]) -> dict[str, Any]:
    """Return the row of a print, from 1, of a recording that was measured."""
    captures = summary['captures']
    return {'bag': name, 'exit_status': 0, 'reason': '', 'results': str(out),
            **{key: summary[key] for key in (
                *TEXT_COLUMNS, *COUNT_COLUMNS, *NUMBER_COLUMNS, 'ooze_count', 'ooze_length_mm')},
            'verdict': summary['verdict']['verdict'],
            'defects': len(summary['verdict']['defects']),
            'print': number, 'captures': len(captures),
            'refused_captures': sum('refusal' in capture for capture in captures),
            'warnings': '; '.join(summary['warnings'])}


def failed(name: str, status: int, reason: str) -> dict[str, Any]:
    """Return the row of a recording that was not measured, with the exit status and the reason."""
    return {**dict.fromkeys(SCHEMA.names), 'bag': name, 'exit_status': status,
            'reason': ' '.join(reason.split())}


def write_table(out: Path, rows: list[dict[str, Any]]) -> list[Path]:
    """Write the rows as prints.csv and prints.parquet, each put in place whole.

    Programs for spreadsheets open the first, so no cell of it is a formula.

    Returns:
        The two files.
    """
    cells = [{name: table_cell(value) if isinstance(value, str) else value
              for name, value in row.items()} for row in rows]
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix='.bpc-', dir=out) as beside:
        csv.write_csv(pyarrow.Table.from_pylist(cells, SCHEMA), Path(beside, 'prints.csv'))
        parquet.write_table(pyarrow.Table.from_pylist(_unicode(rows), SCHEMA),
                            Path(beside, 'prints.parquet'))
        for name in ('prints.csv', 'prints.parquet'):
            os.replace(Path(beside, name), out / name)
    return [out / 'prints.csv', out / 'prints.parquet']


def _unicode(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return rows whose texts are valid Unicode, which a file name need not be."""
    return [{name: value.encode('utf-8', 'replace').decode() if isinstance(value, str) else value
             for name, value in row.items()} for row in rows]
