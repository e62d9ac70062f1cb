"""The distribution of thickness."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.display.legend import STATUS_COLOURS
from bpc_perception.display.units import MM_PER_M
from bpc_perception.report.figures.data import thickness_ceiling
from bpc_perception.report.figures.style import new_figure, reference_line, single

BIN_COUNT = 40


def histogram_figure(profile: ThicknessProfile, targets: WidthTargets | None) -> go.Figure:
    """Draw how often each thickness was measured, and the quartiles."""
    summary, measured = profile.summary, profile.status == Status.MEASURED
    widths, high = profile.thickness[measured] * MM_PER_M, thickness_ceiling(profile, targets)
    low = 0.95 * float(widths.min(initial=high))
    figure = new_figure().add_trace(go.Histogram(
        x=single(widths), xbins={'start': low, 'size': (high - low) / BIN_COUNT}, name='measured',
        marker={'color': STATUS_COLOURS[Status.MEASURED]}, opacity=0.6,
        hovertemplate='%{x} mm: %{y} samples<extra></extra>'))
    lines = [('first quartile', summary.thickness_q1, 'dot'),
             ('median', summary.thickness_median, 'solid'),
             ('third quartile', summary.thickness_q3, 'dot')]
    if targets is not None and np.ptp(targets.thickness) == 0:
        lines.append(('target', float(targets.thickness[0]), 'dash'))
    for name, value, dash in lines:
        if np.isfinite(value):
            figure.add_vline(value * MM_PER_M, name=f'{name} {value * MM_PER_M:.3f} mm',
                             showlegend=True, line=reference_line(dash))
    return figure.update_layout(
        bargap=0.02, yaxis={'title': 'samples', 'fixedrange': True},
        xaxis={'title': 'thickness [mm]', 'range': (low, high)})
