"""The page of a batch: its prints in a table, and their control charts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from bpc_perception.core.inspection.verdict import Verdict
from bpc_perception.display.verdict_words import NAMES
from bpc_perception.report.control.charts import ControlGroup
from bpc_perception.report.pages.control_part import control_figures, control_part
from bpc_perception.report.pages.page import page


def render(out: Path, rows: Sequence[Mapping[str, Any]], groups: Sequence[ControlGroup]) -> str:
    """Make the page.

    Args:
        out: folder that the page is for; links are relative to it.
        rows: of the table of prints.
        groups: the prints that were measured.
    """
    return page('batch.html.j2', control_figures(groups), control=control_part(groups),
                prints=[{**row, 'verdict': NAMES[Verdict[row['verdict']]], 'link': _link(out, row)}
                        for row in rows if not row['exit_status']],
                failed=[row for row in rows if row['exit_status']])


def _link(out: Path, row: Mapping[str, Any]) -> str:
    return quote(str(Path(row['results'], 'report.html').relative_to(out)), errors='replace')
