"""The offset of the filament from the path."""

from __future__ import annotations

from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.display.legend import STATUS_COLOURS, TARGET_COLOUR
from bpc_perception.display.units import MM_PER_M
from bpc_perception.report.figures.data import offset_range
from bpc_perception.report.figures.figure import Figure
from bpc_perception.report.figures.style import (
    axis,
    FULL_HEIGHT_AXIS,
    shade_statuses,
    single,
)


def offset_figure(profile: ThicknessProfile) -> Figure:
    """Draw how far the middle of the deposit lies to the left of the path, over arc length."""
    arc = profile.arc_length * MM_PER_M
    offset = (profile.left - profile.right) / 2 * MM_PER_M
    figure = Figure(legend_y=-0.35)
    shade_statuses(figure, profile)
    figure.add('scatter', x=single(arc), y=single(offset), mode='lines', name='offset',
               line={'color': STATUS_COLOURS[Status.MEASURED], 'width': 1.5},
               hovertemplate='%{y:+.3f} mm at %{x:.1f} mm<extra></extra>')
    figure.add_shape('line', x0=0, x1=1, xref='x domain', y0=0, y1=0, yref='y',
                     line={'color': TARGET_COLOUR, 'width': 1})
    return figure.lay_out(
        xaxis=axis('arc length [mm]'), yaxis2=FULL_HEIGHT_AXIS,
        yaxis=axis('left of the path [mm]', range=offset_range(profile)))
