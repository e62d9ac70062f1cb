"""The files of a batch: its tables, and a page with the control charts."""

from __future__ import annotations

from collections.abc import Collection, Mapping
import os
from pathlib import Path
import tempfile
from typing import Any

from bpc_perception.batch import table
from bpc_perception.report.control.charts import ChartedPrint, control_groups, ControlGroup
from bpc_perception.report.control.tables import control_tables
from bpc_perception.report.pages import batch_page
from bpc_perception.report.result_folder import read_summary
from bpc_perception.report.tables.files import table_files

NAME = 'prints'


def groups_of(rows: list[dict[str, Any]], baseline: int | None) -> list[ControlGroup]:
    """Return the control charts of the prints that were measured.

    Args:
        rows: of the table of prints.
        baseline: the first so many of each group set its limits; None = all.
    """
    several = {row['bag'] for row in rows if (row['print'] or 0) > 1}
    return control_groups((ChartedPrint.of(
        f'{row["bag"]}, print {row["print"]}' if row['bag'] in several else row['bag'],
        read_summary(Path(row['results']))) for row in rows if not row['exit_status']), baseline)


def write_outputs(out: Path, rows: list[dict[str, Any]], groups: list[ControlGroup],
                  formats: Collection[str]) -> list[Path]:
    """Write tables and page; all are complete before the first takes its place.

    Args:
        out: folder, made if missing.
        rows: of the table of prints.
        groups: their control charts.
        formats: of workbooks, beside CSV and Parquet.

    Returns:
        The files.
    """
    tables = (table.prints_table(rows), *control_tables(groups))
    files = {name: data for each in tables for name, data in table.csv_and_parquet(each)}
    files |= table_files(NAME, tables, formats)
    page = batch_page.render(out.absolute(), rows, groups)
    files[f'{NAME}.html'] = page.encode('utf-8', 'replace')
    _put_in_place(out, files)
    return [out / name for name in files]


def _put_in_place(out: Path, files: Mapping[str, bytes]) -> None:
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix='.bpc-', dir=out) as beside:
        for name, data in files.items():
            Path(beside, name).write_bytes(data)
        for name in files:
            os.replace(Path(beside, name), out / name)
