"""What is drawn on a control chart, where; plotly's own classes refuse what they do not know."""

from control_summaries import summary_of
import plotly.graph_objects as go
import pytest

from bpc_perception.report.control.charts import ChartedPrint, control_groups
from bpc_perception.report.figures.control import control_figure

WIDTHS = [1.99 + 0.02 * (number % 2) for number in range(10)] + [None, 2.5]


@pytest.fixture
def figure():
    group, = control_groups((ChartedPrint.of(f'n{hour}', summary_of(
        hour, width, 0.6, 'FAIL' if width == 2.5 else 'PASS'))
        for hour, width in enumerate(WIDTHS)), 10)
    made = control_figure(group)
    return go.Figure(made.traces, made.layout)


def traces(figure, name):
    return [trace for trace in figure.data if trace.name == name]


def test_values_are_drawn_with_their_limits_and_tolerance(figure):
    values, _ = traces(figure, 'mean of a print')
    assert values.x == (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12)
    assert values.y == tuple(width for width in WIDTHS if width)
    centre, = traces(figure, 'centre')  # all heights are the same and have none
    assert centre.y == pytest.approx((2.0, 2.0))
    low, high = traces(figure, 'control limits')
    assert (low.y[0], high.y[0]) == pytest.approx((2 - 0.06 / 1.128, 2 + 0.06 / 1.128))
    assert [trace.y[0] for trace in traces(figure, 'tolerance')] == pytest.approx((1.7, 2.3))


def test_an_alarm_has_a_ring_and_the_baseline_an_end(figure):
    ring, = traces(figure, 'hardly by chance')
    assert (ring.x, ring.y) == ((12,), (2.5,))
    line, = figure.layout.shapes
    assert (line.name, line.x0) == ('end of the baseline', 10.5)


def test_verdicts_are_marked_with_the_share_so_far(figure):
    share, = traces(figure, 'share of good prints so far')
    assert share.y == pytest.approx((*[1.0] * 11, 11 / 12))
    bad, = traces(figure, 'not good')
    assert (bad.x, bad.y) == ((12,), (0.0,))


def test_the_legend_names_each_thing_once(figure):
    named = [trace.name for trace in figure.data if trace.showlegend]
    assert len(named) == len(set(named))
    assert set(named) == {trace.name for trace in figure.data}
