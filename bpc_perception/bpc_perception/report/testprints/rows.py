"""What a test print tells as rows: for sweep.csv and findings.csv, and for a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
import csv
import io
import math
from typing import Any

from bpc_perception.core.testprints.finding import Finding
from bpc_perception.core.testprints.judge import Judgement
from bpc_perception.core.testprints.sweep_judge import LineResult
from bpc_perception.display.plain_json import plain
from bpc_perception.display.units import MM_PER_M, UL_PER_M3
from bpc_perception.files import sweep_table

FINDINGS_FILE = 'findings.csv'
FINDING_COLUMNS = ('of', 'at', 'at_unit', 'quantity', 'value', 'sigma', 'unit', 'samples', 'note')
SHOWN_UNITS = {'m': (MM_PER_M, 'mm'), 'm^2': (MM_PER_M**2, 'mm2'), '%': (1.0, '%'),
               's': (1.0, 's'), 'deg': (1.0, 'deg'), '': (1.0, '')}
KPA_PER_PA = 1e-3


def sweep_row(result: LineResult) -> dict[str, Any]:
    """Return a line of a sweep with lengths in millimetres; NaN = not known."""
    plan = result.plan
    return {
        'line': result.line, 'flow_mm3_s': plan.flow * UL_PER_M3,
        'speed_mm_s': plan.speed * MM_PER_M, 'pressure_kpa': plan.pressure * KPA_PER_PA,
        'temperature_c': plan.temperature,
        'width_mm': result.width * MM_PER_M, 'width_sigma_mm': result.width_sigma * MM_PER_M,
        'height_mm': result.height * MM_PER_M, 'height_sigma_mm': result.height_sigma * MM_PER_M,
        'area_mm2': result.area * MM_PER_M**2, 'area_sigma_mm2': result.area_sigma * MM_PER_M**2,
        'samples': result.samples, 'start_lag_s': result.start.time,
        'stop_lag_s': result.stop.time}


def finding_row(finding: Finding) -> dict[str, Any]:
    """Return a finding with lengths in millimetres; NaN = not known."""
    factor, unit = SHOWN_UNITS[finding.unit]
    at_factor, at_unit = SHOWN_UNITS[finding.at_unit]
    return {'of': finding.of, 'at': at_factor * finding.at, 'at_unit': at_unit,
            'quantity': finding.quantity, 'value': factor * finding.value,
            'sigma': factor * finding.sigma, 'unit': unit, 'samples': finding.samples,
            'note': finding.note}


def line_notes(judgement: Judgement) -> list[Finding]:
    """Return why something of a line is not known, as findings."""
    found = []
    for result in judgement.sweep.lines if judgement.sweep else ():
        of = f'line {result.line}'
        for name, unit, note in (('width', 'm', result.note),
                                 ('start_lag', 's', result.start.note),
                                 ('stop_lag', 's', result.stop.note)):
            if note:
                found.append(Finding(of, math.nan, '', name, math.nan, math.nan, unit, 0, note))
    return found


def judgement_files(judgement: Judgement) -> dict[str, str]:
    """Return the files of a judgement by name, as CSV; an empty cell = not known."""
    files = {FINDINGS_FILE: _csv(FINDING_COLUMNS, map(
        finding_row, [*judgement.findings, *line_notes(judgement)]))}
    if judgement.sweep is not None:
        files[sweep_table.FILE] = _csv(sweep_table.COLUMNS, map(sweep_row, judgement.sweep.lines))
    return files


def _csv(columns: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator='\n')
    writer.writeheader()
    for row in rows:
        writer.writerow({key: '' if value is None else value for key, value in plain(row).items()})
    return text.getvalue()
