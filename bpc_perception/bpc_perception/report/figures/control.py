"""Control charts over prints: width, height and the share of good ones."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.inspection.verdict import Verdict
from bpc_perception.core.profile import Status
from bpc_perception.display.legend import STATUS_COLOURS, TARGET_COLOUR, TOO_THICK_COLOUR
from bpc_perception.display.verdict_words import NAMES
from bpc_perception.report.control.charts import Chart, ControlGroup
from bpc_perception.report.control.tables import moment
from bpc_perception.report.figures.figure import Figure
from bpc_perception.report.figures.style import axis, reference_line

VALUE_COLOUR = STATUS_COLOURS[Status.MEASURED]
ALARM_COLOUR = TOO_THICK_COLOUR
GOOD_COLOUR = '#009E73'
# Height, symbol and colour.
VERDICT_MARKS = {Verdict.PASS: (1.0, 'circle', GOOD_COLOUR),
                 Verdict.FAIL: (0.0, 'x', ALARM_COLOUR),
                 Verdict.NOT_ENOUGH_SEEN: (0.5, 'circle-open', TARGET_COLOUR)}
GAP = 0.06  # between charts, as a share of the figure's height
VERDICT_SHARE = 0.22  # of the figure's height


def control_figure(group: ControlGroup) -> Figure:
    """Draw the charts of a group below each other, prints from left to right."""
    figure = Figure(legend_y=-0.13)
    count = len(group.prints)
    hover = [f'{place}: {each.name}<br>{moment(each.stamp_ns)}'
             for place, each in enumerate(group.prints, 1)]
    height = (1 - VERDICT_SHARE) / len(group.charts)
    axes = {}
    for place, chart in enumerate(group.charts):
        name, top = 'y' if place == 0 else f'y{place + 1}', 1 - place * height
        axes[name.replace('y', 'yaxis')] = axis(f'{chart.quantity} [mm]',
                                                domain=(top - height + GAP, top))
        _add_lines(figure, chart, name, count)
        _add_values(figure, chart, name, hover)
    _add_verdicts(figure, group, hover)
    if group.baseline is not None and group.baseline < count:
        at = group.baseline + 0.5
        figure.add_shape('line', x0=at, x1=at, y0=0, y1=1, yref='paper', showlegend=True,
                         name='end of the baseline', line={'color': TARGET_COLOUR, 'width': 0.8})
    _name_once(figure)
    return figure.lay_out(
        **axes, yaxis9=axis('good', domain=(0, VERDICT_SHARE - GAP), range=(-0.1, 1.1),
                            tickformat='.0%', tickvals=(0, 0.5, 1)),
        xaxis=axis('number of the print', anchor='y9', range=(0.5, count + 0.5), tickformat='d'))


def _add_lines(figure: Figure, chart: Chart, name: str, count: int) -> None:
    """Draw limits, target and tolerance of a chart on the axis of this name."""
    limits, (low, high) = chart.limits, chart.tolerance
    control = {'color': ALARM_COLOUR, 'width': 1}
    lines = (('centre', limits.centre, {'color': VALUE_COLOUR, 'width': 1}),
             ('control limits', limits.lower, control), ('control limits', limits.upper, control),
             ('target', chart.target, reference_line('dash')),
             ('tolerance', low, reference_line('dot')), ('tolerance', high, reference_line('dot')))
    for label, height, style in lines:
        if np.isfinite(height):
            figure.add('scatter', x=(0.5, count + 0.5), y=(height, height), yaxis=name,
                       mode='lines', name=label, line=style,
                       hovertemplate='%{y:.3f} mm<extra>' + label + '</extra>')


def _add_values(figure: Figure, chart: Chart, name: str, hover: list[str]) -> None:
    """Draw the values of a chart; what is hardly by chance has a ring."""
    known = np.flatnonzero(np.isfinite(chart.values)).tolist()
    figure.add('scatter', x=[place + 1 for place in known], y=chart.values[known].tolist(),
               yaxis=name, mode='lines+markers', name='mean of a print',
               line={'color': VALUE_COLOUR, 'width': 1}, marker={'size': 6},
               text=[hover[place] for place in known],
               hovertemplate='%{y:.3f} mm<br>%{text}<extra></extra>')
    marked = {place: alarm.rule.value for alarm in chart.alarms
              for place in range(alarm.start, alarm.end) if place in known}
    if marked:
        figure.add('scatter', x=[place + 1 for place in marked],
                   y=chart.values[list(marked)].tolist(), yaxis=name, mode='markers',
                   name='hardly by chance', hoverinfo='skip',
                   marker={'size': 13, 'symbol': 'circle-open', 'color': ALARM_COLOUR,
                           'line': {'width': 2}})


def _name_once(figure: Figure) -> None:
    """Let the legend name what is drawn several times but once."""
    named: set[str] = set()
    for trace in figure.traces:
        trace |= {'legendgroup': trace['name'], 'showlegend': trace['name'] not in named}
        named.add(trace['name'])


def _add_verdicts(figure: Figure, group: ControlGroup, hover: list[str]) -> None:
    """Draw each verdict as a mark, above for good, and the share of good prints up to there."""
    share = group.good_share
    figure.add('scatter', x=list(range(1, len(share) + 1)), y=[
        None if np.isnan(value) else value for value in share],
               yaxis='y9', mode='lines', name='share of good prints so far',
               line={'color': GOOD_COLOUR, 'width': 1.5},
               hovertemplate='%{y:.0%} good up to print %{x}<extra></extra>')
    for verdict, (height, symbol, colour) in VERDICT_MARKS.items():
        own = [place for place, each in enumerate(group.prints) if each.verdict == verdict]
        if own:
            figure.add('scatter', x=[place + 1 for place in own], y=[height] * len(own),
                       yaxis='y9', mode='markers', name=NAMES[verdict],
                       marker={'size': 8, 'symbol': symbol, 'color': colour},
                       text=[hover[place] for place in own],
                       hovertemplate=f'{NAMES[verdict]}<br>%{{text}}<extra></extra>')
