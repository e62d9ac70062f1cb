"""The page about the window of an ink."""

from __future__ import annotations

from collections.abc import Sequence
import math

import numpy as np

from bpc_perception.core.profile import Status
from bpc_perception.core.window.assess import InkWindow
from bpc_perception.core.window.sweep import column, Drive, SweepLine
from bpc_perception.core.window.window import MET
from bpc_perception.display.legend import STATUS_COLOURS, TARGET_COLOUR
from bpc_perception.display.units import MM_PER_M
from bpc_perception.report.figures.figure import Figure
from bpc_perception.report.figures.style import axis, single
from bpc_perception.report.pages.page import page
from bpc_perception.report.window.rows import (
    DRIVES,
    law,
    settings,
    size_values,
    SIZES,
    speed_rows,
    ticks,
)

WINDOW_COLOUR = 'rgba(0, 158, 115, 0.25)'
CLEAR = 'rgba(0, 0, 0, 0)'
DRIVE_TITLES = {Drive.FLOW: 'flow [mm³/s]', Drive.PRESSURE: 'pressure [kPa]'}
UNITS = {'mm3_s': 'mm³/s', 'mm_s': 'mm/s', 'kpa': 'kPa', 'mm2': 'mm²', 'mm': 'mm', 'c': '°C',
         's': 's'}
ROWS = 13  # speeds in the table


def render(window: InkWindow, sources: Sequence[str]) -> str:
    """Make the page about the window of an ink, which is from these sweeps."""
    rows = speed_rows(window)
    return page(
        'window.html.j2', {'window': window_figure(window)}, sources=list(sources),
        settings=[(_words(name), value) for name, value in settings(window).items()
                  if not name.startswith(('expected_', 'chance'))],
        expected=[(of, list(size_values(of, expected).values()), SIZES[of][0].replace('2', '²'))
                  for of, expected in window.expected.items()],
        laws=[(law(model), 100 * model.scatter, len(model.lines))
              for model in window.models.values()],
        headings=[_words(name) for name in rows[0] if not _is_detail(name)],
        rows=[[value for name, value in row.items() if not _is_detail(name)]
              for row in rows[::max(1, len(rows) // (ROWS - 1))]],
        target=window.wanted.width * MM_PER_M, tolerance=100 * window.wanted.tolerance,
        chance=min(100 * window.chance, 99.9), least_chance=100 * MET,
        strangers=[(each.name, 100 * each.deviation) for each in window.strangers],
        failed=[line.name for line in window.lines if not math.isfinite(line.width)])


def window_figure(window: InkWindow) -> Figure:
    """Draw window, curves of equal width, lines and the recommended setting."""
    figure, grid = Figure(), window.grid
    factor = DRIVES[window.proven.drive][2]
    places = {'x': single(grid.speed * MM_PER_M), 'y': single(grid.drive * factor)}
    width = single(np.where(grid.proven, grid.width * MM_PER_M, np.nan).T)
    figure.add('contour', **places, z=single(np.nan_to_num(grid.chance).T), showscale=False,
               contours={'start': MET, 'end': MET, 'size': 1, 'showlines': False},
               colorscale=[[0, CLEAR], [0.5, CLEAR], [0.5, WINDOW_COLOUR], [1, WINDOW_COLOUR]],
               zmin=MET - 1, zmax=MET + 1, hoverinfo='skip', showlegend=False)
    figure.add('contour', **places, z=width, showscale=False, name='width [mm]',
               contours={'coloring': 'none', 'showlabels': True}, ncontours=12,
               line={'color': '#9A9A9A', 'width': 1}, showlegend=False,
               hovertemplate='%{z:.3f} mm at %{x:.3g} mm/s, %{y:.3g}<extra></extra>')
    target = window.wanted.width * MM_PER_M
    figure.add('contour', **places, z=width, showscale=False, name='target',
               contours={'coloring': 'none', 'start': target, 'end': target, 'size': 1},
               line={'color': TARGET_COLOUR, 'width': 2}, showlegend=True, hoverinfo='skip')
    figure.add('scatter', x=[None], y=[None], mode='markers', name='in tolerance',
               marker={'symbol': 'square', 'size': 12, 'color': WINDOW_COLOUR})
    _add_lines(figure, window, window.proven.good, 'line', {'color': '#0072B2', 'size': 8})
    _add_lines(figure, window, window.proven.failed, 'line without a width',
               {'color': STATUS_COLOURS[Status.GAP], 'size': 9, 'symbol': 'x'})
    figure.add('scatter', x=[window.speed * MM_PER_M], y=[window.drive * factor], mode='markers',
               name='recommended', marker={'symbol': 'star', 'size': 16, 'color': TARGET_COLOUR},
               hovertemplate='recommended: %{x:.3g} mm/s, %{y:.4g}<extra></extra>')
    (least, largest), (slowest, fastest) = window.proven.limits
    return figure.lay_out(
        xaxis=axis('speed [mm/s]', type='log', tickvals=ticks(slowest * MM_PER_M,
                                                              fastest * MM_PER_M)),
        yaxis=axis(DRIVE_TITLES[window.proven.drive], type='log',
                   tickvals=ticks(least * factor, largest * factor)))


def _add_lines(figure: Figure, window: InkWindow, lines: Sequence[SweepLine], name: str,
               marker: dict[str, object]) -> None:
    if not lines:
        return
    drive = window.proven.drive
    width = column(lines, 'width') * MM_PER_M
    figure.add('scatter', x=single(column(lines, 'speed') * MM_PER_M),
               y=single(column(lines, drive.value) * DRIVES[drive][2]), mode='markers', name=name,
               marker=marker, text=[f'{line.name}: {value:.3f} mm' if math.isfinite(value)
                                    else f'{line.name}: no width'
                                    for line, value in zip(lines, width.tolist(), strict=True)],
               hovertemplate='%{text}<extra></extra>')


def _is_detail(name: str) -> bool:
    """Tell whether a column is for window.csv only: the uncertainty of a size."""
    return name.startswith(tuple(SIZES)) and not name.startswith('width_spread') and any(
        f'_{detail}_' in name for detail in ('sigma', 'spread', 'low', 'high'))


def _words(name: str) -> str:
    """Return the name of a column for people, with its unit in brackets."""
    for ending, unit in UNITS.items():
        if name.endswith(f'_{ending}'):
            return f'{name.removesuffix(f"_{ending}").replace("_", " ")} [{unit}]'
    return name.replace('_', ' ')
