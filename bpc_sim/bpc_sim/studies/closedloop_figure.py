"""Width and rate over the length of prints that go wrong, with and without feedback."""

from __future__ import annotations

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from bpc_sim.closed_loop.situations import situation, SITUATIONS
from bpc_sim.studies.closedloop import run

COLOURS = {'none': '#999999', 'mass_balance': '#d9822b', 'pi': '#7a4fb5', 'advice': '#1f5fbf'}
SEED = 0
EVERY = 5  # of the points along the path, a millimetre
MM = 1e3


def draw() -> str:
    """A page with a row for each scenario: width, and the factor on the nominal flow."""
    titles = [text for name in SITUATIONS for text in (name.replace('_', ' '), '')]
    page = make_subplots(len(SITUATIONS), 2, subplot_titles=titles, vertical_spacing=0.009)
    for number, name in enumerate(SITUATIONS, 1):
        print_ = situation(name, SEED)
        for controller, colour in COLOURS.items():
            trace = run(print_, controller)
            s = trace.s[::EVERY] * MM
            look = {'mode': 'lines', 'legendgroup': controller, 'name': controller,
                    'line': {'color': colour, 'width': 1.5}}
            page.add_scatter(x=s, y=trace.width[::EVERY] * MM, showlegend=number == 1, **look,
                             row=number, col=1)
            page.add_scatter(x=s, y=trace.scale[::EVERY], showlegend=False, **look,
                             row=number, col=2)
        page.add_trace(go.Scatter(
            x=s, y=trace.target[::EVERY] * MM, mode='lines', name='target', legendgroup='target',
            showlegend=number == 1, line={'color': '#222', 'dash': 'dash', 'width': 1}), number, 1)
        page.update_yaxes(title='width [mm]', range=(0, 4), row=number, col=1)
        page.update_yaxes(title='factor', range=(0.4, 2.1), row=number, col=2)
    page.update_xaxes(title='path [mm]', row=len(SITUATIONS))
    page.update_layout(title=f'One print of each scenario, seed {SEED}',
                       height=260 * len(SITUATIONS),
                       template='plotly_white', legend={'orientation': 'h', 'y': 1.005})
    return str(page.to_html(include_plotlyjs=True))
