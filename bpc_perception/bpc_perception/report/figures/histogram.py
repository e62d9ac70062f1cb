"""The distribution of thickness."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets
from bpc_perception.display.legend import STATUS_COLOURS
from bpc_perception.display.units import MM_PER_M
from bpc_perception.report.figures.data import thickness_ceiling
from bpc_perception.report.figures.figure import Figure
from bpc_perception.report.figures.style import axis, reference_line, single

BIN_COUNT = 40


def histogram_figure(profile: ThicknessProfile, targets: WidthTargets | None) -> Figure:
    """Draw how often each thickness was measured, and the quartiles."""
    summary, measured = profile.summary, profile.status == Status.MEASURED
    widths, high = profile.thickness[measured] * MM_PER_M, thickness_ceiling(profile, targets)
    low = 0.95 * float(widths.min(initial=high))
    figure = Figure()
    figure.add('histogram', x=single(widths), name='measured',
               xbins={'start': low, 'size': (high - low) / BIN_COUNT},
               marker={'color': STATUS_COLOURS[Status.MEASURED]}, opacity=0.6,
               hovertemplate='%{x} mm: %{y} samples<extra></extra>')
    lines = [('first quartile', summary.thickness_q1, 'dot'),
             ('median', summary.thickness_median, 'solid'),
             ('third quartile', summary.thickness_q3, 'dot')]
    if targets is not None and np.ptp(targets.thickness) == 0:
        lines.append(('target', float(targets.thickness[0]), 'dash'))
    for name, value, dash in lines:
        if np.isfinite(value):
            place = value * MM_PER_M
            figure.add_shape('line', x0=place, x1=place, xref='x', y0=0, y1=1, yref='y domain',
                             name=f'{name} {place:.3f} mm', showlegend=True,
                             line=reference_line(dash))
    return figure.lay_out(bargap=0.02, yaxis=axis('samples', fixedrange=True),
                          xaxis=axis('thickness [mm]', range=(low, high)))
