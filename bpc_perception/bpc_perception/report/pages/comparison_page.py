"""Two or more prints beside each other: curves, a table, and what was not alike."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.display.legend import PRINT_COLOURS
from bpc_perception.report.comparison import (
    cells,
    COLUMNS,
    differences,
    LAYER_COLUMNS,
    layer_rows,
    PrintResult,
    rows,
)
from bpc_perception.report.control.charts import ControlGroup
from bpc_perception.report.figures.data import pen_up
from bpc_perception.report.figures.figure import Figure
from bpc_perception.report.figures.style import axis, reference_line, single
from bpc_perception.report.pages.control_part import control_figures, control_part
from bpc_perception.report.pages.page import page

GAP_ROW_SHARE = 0.04  # of the largest thickness, from one print's row of gaps to the next
CURVE_WIDTH_PX, GAP_WIDTH_PX = 1.5, 6


def render(prints: Sequence[PrintResult], groups: Sequence[ControlGroup] = ()) -> str:
    """Make the page about these prints; groups are the same prints for control charts."""
    colours = [PRINT_COLOURS[number % len(PRINT_COLOURS)] for number in range(len(prints))]
    coloured = list(zip(prints, colours, strict=True))
    return page(
        'compare.html.j2',
        {'thickness': _thickness_figure(coloured), 'histogram': _histogram_figure(coloured),
         **control_figures(groups)},
        control=control_part(groups),
        headings=['verdict', *(column.heading for column in COLUMNS)],
        rows=list(zip(colours, map(cells, rows(prints)), strict=True)),
        layer_headings=[column.heading for column in LAYER_COLUMNS],
        layers=[(layer, colours[number], prints[number].name, words)
                for layer, number, words in layer_rows(prints)],
        names=[print_.name for print_ in prints], differences=differences(prints))


def _thickness_figure(prints: Sequence[tuple[PrintResult, str]]) -> Figure:
    """Draw thickness over arc length; gaps are bars below the axis, a row for each print."""
    figure = Figure()
    row_height = GAP_ROW_SHARE * max(
        print_.thickness[print_.measured].max(initial=0.0) for print_, _ in prints)
    for number, (print_, colour) in enumerate(prints, 1):
        # A gap is drawn below the axis only: it must not pull the curve beside it down to 0.
        thickness = np.where(print_.gap, np.nan, print_.thickness)
        _add_line(figure, print_, thickness, print_.measured, name=print_.name,
                  legendgroup=print_.name, showlegend=True,
                  line={'color': colour, 'width': CURVE_WIDTH_PX},
                  hovertemplate='%{y:.3f} mm at %{x:.1f} mm')
        bar_height = np.full(len(print_.gap), -row_height * number)
        _add_line(figure, print_, bar_height, print_.gap, name=f'{print_.name}: gap',
                  legendgroup=print_.name, showlegend=False,
                  line={'color': colour, 'width': GAP_WIDTH_PX},
                  hovertemplate='gap at %{x:.1f} mm')
    for target in sorted({print_.target_mm for print_, _ in prints if print_.target_mm}):
        figure.add_shape('line', x0=0, x1=1, xref='x domain', y0=target, y1=target, name='target',
                         showlegend=True, line=reference_line('dash'))
    return figure.lay_out(xaxis=axis('arc length [mm]'),
                          yaxis=axis('thickness [mm]', rangemode='tozero'))


def _add_line(figure: Figure, print_: PrintResult, height: Array, chosen: NDArray[np.bool_],
              **style: object) -> None:
    """Draw heights (N,) [mm] over arc length where they are chosen (N,)."""
    line = pen_up(np.column_stack((print_.arc_length, height)), chosen)
    figure.add('scatter', x=single(line[:, 0]), y=single(line[:, 1]), mode='lines', **style)


def _histogram_figure(prints: Sequence[tuple[PrintResult, str]]) -> Figure:
    """Draw the shares of the measured samples by thickness."""
    figure = Figure()
    for print_, colour in prints:
        figure.add('histogram', x=single(print_.thickness[print_.measured]), name=print_.name,
                   histnorm='percent', bingroup='all', opacity=0.5, marker={'color': colour},
                   hovertemplate='%{x} mm: %{y:.1f} %')
    return figure.lay_out(barmode='overlay', xaxis=axis('thickness [mm]'),
                          yaxis=axis('measured samples [%]'))
