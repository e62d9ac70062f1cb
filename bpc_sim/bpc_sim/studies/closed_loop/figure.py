"""Width and rate over the length of prints that go wrong, with and without feedback."""

from __future__ import annotations

from typing import Any

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from bpc_perception.display.units import MM_PER_M
from bpc_sim.closed_loop.model import Trace
from bpc_sim.closed_loop.situations import make_situation, SITUATIONS
from bpc_sim.studies.closed_loop.trial import run_print

COLOURS = {'none': '#999999', 'mass_balance': '#d9822b', 'pi': '#7a4fb5', 'advice': '#1f5fbf'}
SEED = 0
POINT_STRIDE = 5  # along the path: a point each millimetre


def draw() -> str:
    """Return a page with a row for each scenario: width, and factor on the nominal flow."""
    titles = [text for name in SITUATIONS for text in (name.replace('_', ' '), '')]
    page = make_subplots(len(SITUATIONS), 2, subplot_titles=titles, vertical_spacing=0.009)
    for row, name in enumerate(SITUATIONS, 1):
        print_ = make_situation(name, SEED)
        for controller, colour in COLOURS.items():
            trace = run_print(print_, controller)
            _add_controller(page, trace, controller, colour, row)
        _add_target(page, trace, row)
        page.update_yaxes(title='width [mm]', range=(0, 4), row=row, col=1)
        page.update_yaxes(title='factor', range=(0.4, 2.1), row=row, col=2)
    page.update_xaxes(title='path [mm]', row=len(SITUATIONS))
    page.update_layout(title=f'One print of each scenario, seed {SEED}',
                       height=260 * len(SITUATIONS),
                       template='plotly_white', legend={'orientation': 'h', 'y': 1.005})
    return str(page.to_html(include_plotlyjs=True))


def _add_controller(page: Any, trace: Trace, name: str, colour: str, row: int) -> None:
    """Draw width and factor of a print under a controller into a row."""
    s = trace.s[::POINT_STRIDE] * MM_PER_M
    look = {'mode': 'lines', 'legendgroup': name, 'name': name,
            'line': {'color': colour, 'width': 1.5}}
    page.add_scatter(x=s, y=trace.width[::POINT_STRIDE] * MM_PER_M, showlegend=row == 1, **look,
                     row=row, col=1)
    page.add_scatter(x=s, y=trace.scale[::POINT_STRIDE], showlegend=False, **look, row=row, col=2)


def _add_target(page: Any, trace: Trace, row: int) -> None:
    """Draw the wanted width into a row."""
    page.add_trace(go.Scatter(
        x=trace.s[::POINT_STRIDE] * MM_PER_M, y=trace.target[::POINT_STRIDE] * MM_PER_M,
        mode='lines', name='target', legendgroup='target', showlegend=row == 1,
        line={'color': '#222', 'dash': 'dash', 'width': 1}), row, 1)
