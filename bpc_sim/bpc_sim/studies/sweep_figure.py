"""The figure of a sweep, as a page that needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from bpc_sim.studies.study_runner import METHODS, Row

COLOURS = dict(zip(METHODS, ('#1f5fbf', '#d9822b'), strict=True))
LABELS = {'ratio': 'resolution ratio', 'width_mm': 'thickness [mm]', 'time_ms': 'time [ms]',
          'MAE_percent': 'MAE [% of the thickness]'}
LOGARITHMIC_COLUMNS = {'MAE_percent'}  # the methods differ by a power of ten


def draw_sweep(title: str, rows: list[Row], axes: Sequence[str]) -> str:
    """Return a page with a panel for each column along y.

    Args:
        title: title of the figure.
        rows: rows of the study.
        axes: names of the column along x and of those along y.
    """
    along, *columns = axes
    drawn = make_subplots(1, len(columns))
    for panel, column in enumerate(columns, 1):
        for method, colour in COLOURS.items():
            mine = [row for row in rows if row['method'] == method]
            drawn.add_trace(go.Scatter(
                x=[row[along] for row in mine], y=[row[column] for row in mine], name=method,
                mode='lines+markers', line={'color': colour}, legendgroup=method,
                showlegend=panel == 1), 1, panel)
        drawn.update_xaxes(title=LABELS[along], row=1, col=panel)
        drawn.update_yaxes(title=LABELS[column], row=1, col=panel,
                           **({'type': 'log', 'dtick': 1} if column in LOGARITHMIC_COLUMNS
                              else {'rangemode': 'tozero'}))
    drawn.update_layout(title=title, template='plotly_white', height=480,
                        legend={'orientation': 'h', 'y': -0.2})
    return str(drawn.to_html(include_plotlyjs=True))
