"""Metrics and pores as rows: for printability.csv, for a terminal, and for scripts."""

from __future__ import annotations

import csv
import io
import math
from typing import Any

from bpc_perception.core.printability.assess import Printability
from bpc_perception.core.printability.definitions import DEFINITIONS
from bpc_perception.core.printability.metric import Metric
from bpc_perception.core.printability.pores import Pore
from bpc_perception.display.units import MM_PER_M

FILE = 'printability.csv'
COLUMNS = ('print', 'row', 'of', 'metric', 'value', 'sigma', 'spread', 'unit', 'samples', 'note',
           'definition', 'source', 'pore', 'layers', 'x_mm', 'y_mm', 'z_mm', 'area_mm2',
           'area_sigma_mm2', 'perimeter_mm', 'perimeter_sigma_mm', 'pr', 'pr_sigma', 'pr_ideal',
           'intended_area_mm2', 'mesh_printability_percent',
           'mesh_printability_sigma_percent', 'interpolated')
SHOWN_UNITS = {'m': (MM_PER_M, 'mm'), 'm^2': (MM_PER_M**2, 'mm2'), '%': (1.0, '%'), '': (1.0, '')}


def metric_row(metric: Metric) -> dict[str, Any]:
    """Return a metric with lengths in millimetres; NaN = not known."""
    definition = metric.definition
    factor, unit = SHOWN_UNITS[definition.unit]
    return {'of': metric.of, 'metric': metric.name, 'value': factor * metric.value,
            'sigma': factor * metric.sigma, 'spread': factor * metric.spread, 'unit': unit,
            'samples': metric.samples, 'note': metric.note, 'definition': definition.text,
            'source': definition.source}


def pore_row(pore: Pore) -> dict[str, Any]:
    """Return a pore with lengths in millimetres; NaN = not known."""
    x, y, z = (pore.centre * MM_PER_M).tolist()
    return {
        'of': f'pore {pore.number}', 'pore': pore.number,
        'layers': ' and '.join(map(str, pore.layers)), 'x_mm': x, 'y_mm': y, 'z_mm': z,
        'area_mm2': pore.area * MM_PER_M**2, 'area_sigma_mm2': pore.area_sigma * MM_PER_M**2,
        'perimeter_mm': pore.perimeter * MM_PER_M,
        'perimeter_sigma_mm': pore.perimeter_sigma * MM_PER_M,
        'pr': pore.printability, 'pr_sigma': pore.printability_sigma, 'pr_ideal': pore.ideal,
        'intended_area_mm2': pore.intended_area * MM_PER_M**2,
        'mesh_printability_percent': pore.mesh_printability,
        'mesh_printability_sigma_percent': pore.mesh_printability_sigma,
        'interpolated': pore.interpolated, 'samples': pore.samples, 'note': pore.note,
        'definition': DEFINITIONS['pore_printability'].text,
        'source': DEFINITIONS['pore_printability'].source}


def printability_csv(found: Printability, print_id: str) -> str:
    """Return a row for each metric and each pore as CSV with a header; an empty cell = not known.

    Numbers have as many digits as it takes to read the same number back.
    """
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator='\n')
    writer.writeheader()
    for kind, rows in (('metric', map(metric_row, found.metrics)),
                       ('pore', map(pore_row, found.pores))):
        for row in rows:
            cells = {key: _cell(value) for key, value in row.items()}
            writer.writerow({'print': print_id, 'row': kind, **cells})
    return text.getvalue()


def _cell(value: object) -> object:
    return '' if isinstance(value, float) and math.isnan(value) else value
