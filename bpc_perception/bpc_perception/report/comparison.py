"""Two or more prints beside each other, from what was left behind of them."""

from __future__ import annotations

from collections.abc import Sequence
import csv
from dataclasses import dataclass
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
import plotly.graph_objects as go

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status
from bpc_perception.display.legend import PRINTS
from bpc_perception.report.figures import layout, pen_up
from bpc_perception.report.html import page

# Columns of the table: key of summary.json, heading, factor, digits.
TABLE = (
    ('path_length_mm', 'path [mm]', 1, 1), ('thickness_mean_mm', 'mean [mm]', 1, 3),
    ('thickness_std_mm', 'std. [mm]', 1, 3), ('thickness_q1_mm', 'Q1 [mm]', 1, 3),
    ('thickness_median_mm', 'Q2 [mm]', 1, 3), ('thickness_q3_mm', 'Q3 [mm]', 1, 3),
    ('thickness_variation', 'variation [%]', 100, 1),
    ('within_10_percent', 'within ±10 % [%]', 100, 1), ('coverage', 'known [%]', 100, 1),
    ('gap_count', 'gaps', 1, 0), ('gap_length_mm', 'gaps [mm]', 1, 1),
    ('offset_rms_mm', 'offset RMS [mm]', 1, 3))


@dataclass(frozen=True)
class PrintResult:
    """What was left behind of a print.

    Attributes:
        name: what it is called among the others.
        summary: content of summary.json.
        arc_length: (N,) [mm].
        thickness: (N,) [mm]; NaN = not known.
        measured, gap: (N,) where the status is MEASURED and GAP.
    """

    name: str
    summary: dict[str, Any]
    arc_length: Array
    thickness: Array
    measured: NDArray[np.bool_]
    gap: NDArray[np.bool_]


def load(folders: Sequence[Path]) -> list[PrintResult]:
    """The prints in these folders, called like them.

    Raises:
        ValueError: a folder holds no result; the message names what was expected and found.
    """
    short = [folder.absolute().name for folder in folders]
    names = short if len(set(short)) == len(short) else [str(folder) for folder in folders]
    return [_load(folder, name) for folder, name in zip(folders, names, strict=True)]


def _load(folder: Path, name: str) -> PrintResult:
    for file in ('profile.csv', 'summary.json'):
        if not (folder / file).is_file():
            raise ValueError(f'{folder}: expected a folder with profile.csv and summary.json, '
                             f'found no {file}')
    try:
        summary = json.loads((folder / 'summary.json').read_text('utf-8'))
        missing = [key for key in ('print_id', 'thickness_mean_mm') if key not in summary]
    except (ValueError, TypeError) as error:
        raise ValueError(f'{folder / "summary.json"}: expected a summary as JSON, '
                         f'found: {error}') from error
    if missing:
        raise ValueError(f'{folder / "summary.json"}: expected {missing[0]}, found none')
    try:
        with (folder / 'profile.csv').open(encoding='utf-8', newline='') as stream:
            rows = list(csv.DictReader(stream))
        arc, thickness = (np.array([float(row[key] or 'nan') for row in rows])
                          for key in ('arc_length_mm', 'thickness_mm'))
        status = np.array([Status[row['status']] for row in rows], np.uint8)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f'{folder / "profile.csv"}: expected a profile as bpc writes it, '
                         f'found: {error!r}') from error
    return PrintResult(name, summary, arc, thickness, status == Status.MEASURED,
                       status == Status.GAP)


def rows(prints: Sequence[PrintResult]) -> list[dict[str, Any]]:
    """A flat row a print, with the keys of summary.json."""
    return [{'print': each.name, **{key: each.summary.get(key) for key, *_ in TABLE}}
            for each in prints]


def cells(row: dict[str, Any]) -> list[str]:
    """A row in words: the numbers in the units of the headings."""
    return [row['print'], *('-' if row[key] is None else f'{factor * row[key]:.{digits}f}'
                            for key, _, factor, digits in TABLE)]


def differences(prints: Sequence[PrintResult]) -> list[tuple[str, list[str]]]:
    """Names and values of what the prints were not measured alike with."""
    told = [{'recording': each.summary.get('bag'), 'capture': each.summary.get('capture'),
             'hand-eye calibration': each.summary.get('hand_eye'),
             **each.summary.get('versions', {}), **each.summary.get('settings', {})}
            for each in prints]
    names = dict.fromkeys(name for each in told for name in each)
    found = [(name, [str(each.get(name, '-')) for each in told]) for name in names]
    return [(name, values) for name, values in found if len(set(values)) > 1]


def render(prints: Sequence[PrintResult]) -> str:
    """The page."""
    coloured = [(each, PRINTS[number % len(PRINTS)]) for number, each in enumerate(prints)]
    return page(
        'compare.html.j2',
        {'thickness': _thickness(coloured), 'histogram': _histogram(coloured)},
        headings=[heading for _, heading, _, _ in TABLE],
        rows=[(colour, cells(row)) for row, (_, colour) in zip(
            rows(prints), coloured, strict=True)],
        names=[each.name for each in prints], differences=differences(prints))


def _thickness(prints: Sequence[tuple[PrintResult, str]]) -> go.Figure:
    """Thickness over arc length; gaps are bars below the axis, a row for each print."""
    figure = go.Figure()
    row = 0.04 * max(each.thickness[each.measured].max(initial=0.0) for each, _ in prints)
    for number, (each, colour) in enumerate(prints, 1):
        # A gap is below the axis along all of it, and what is measured beside it no lower for it.
        for name, chosen, height, width in (
                (each.name, each.measured, np.where(each.gap, np.nan, each.thickness), 1.5),
                (f'{each.name}: gap', each.gap, np.full(len(each.gap), -row * number), 6)):
            line = pen_up(np.column_stack((each.arc_length, height)), chosen)
            figure.add_scatter(
                x=line[:, 0].astype(np.float32), y=line[:, 1].astype(np.float32), mode='lines',
                name=name, legendgroup=each.name, showlegend=name == each.name,
                line={'color': colour, 'width': width},
                hovertemplate='%{y:.3f} mm at %{x:.1f} mm' if name == each.name else
                'gap at %{x:.1f} mm')
    return figure.update_layout(layout(), xaxis={'title': 'arc length [mm]'},
                                yaxis={'title': 'thickness [mm]', 'rangemode': 'tozero'})


def _histogram(prints: Sequence[tuple[PrintResult, str]]) -> go.Figure:
    """Shares of the measured samples, by thickness."""
    figure = go.Figure()
    for each, colour in prints:
        figure.add_histogram(x=each.thickness[each.measured].astype(np.float32), name=each.name,
                             histnorm='percent', bingroup='all', opacity=0.5,
                             marker={'color': colour},
                             hovertemplate='%{x} mm: %{y:.1f} %')
    return figure.update_layout(layout(), barmode='overlay', xaxis={'title': 'thickness [mm]'},
                                yaxis={'title': 'measured samples [%]'})
