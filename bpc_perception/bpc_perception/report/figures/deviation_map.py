"""The filament in 3-D, coloured by its deviation from the target."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets
from bpc_perception.display.layers import layers_of
from bpc_perception.display.legend import (
    FULL_COLOUR_DEVIATION,
    ON_TARGET_COLOUR,
    STATUS_COLOURS,
    TOO_THICK_COLOUR,
    TOO_THIN_COLOUR,
)
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.wording import label
from bpc_perception.report.figures.data import on_map, pen_up
from bpc_perception.report.figures.figure import Figure
from bpc_perception.report.figures.style import axis, single
from bpc_perception.report.uniformity import reference

BACKGROUND_COLOUR = '#4D4D4D'  # a grey on which all colours of the deviation show
OCCLUDED_COLOUR = 'white'  # the black of the legend would not show on that grey
MOST_SAMPLES = 4000
PERCENT = 100


def map_figure(profile: ThicknessProfile, targets: WidthTargets | None) -> Figure:
    """Draw the filament in the base frame, as wide as measured, coloured by its deviation.

    The deviation is from the target, or from the median without one.
    """
    figure = Figure(legend_y=0)
    for layer, own in layers_of(profile):
        _add_ribbon(figure, profile, targets, layer, own)
    _add_unmeasured(figure, profile)
    return figure.lay_out(
        margin={'l': 20, 'r': 20, 't': 70, 'b': 0}, scene=_scene(profile),
        coloraxis=_colours('median' if targets is None else 'target'))


def _add_ribbon(figure: Figure, profile: ThicknessProfile,
                targets: WidthTargets | None, layer: int, own: NDArray[np.bool_]) -> None:
    """Draw two triangles from each sample of a layer to the next where both are measured."""
    # Draw every n-th sample only of a long print.
    shown = slice(None, None, -(-len(profile) // MOST_SAMPLES) or 1)
    thickness, arc = (values[shown] for values in (profile.thickness, profile.arc_length))
    sides = [points[shown] for points in (profile.left_points, profile.right_points)]
    measured = own[shown] & (profile.status[shown] == Status.MEASURED) & np.isfinite(
        sides[0] + sides[1]).all(axis=1)
    stroke = profile.stroke[shown]
    starts = np.flatnonzero(measured[:-1] & measured[1:] & (stroke[:-1] == stroke[1:]))
    if not len(starts):
        return
    # Corners of no triangle lie on one: plotly makes room for them as well.
    left, right = (np.where(measured[:, None], points, points[starts[0]]) * MM_PER_M
                   for points in sides)
    deviation = PERCENT * (thickness / reference(profile, targets)[shown] - 1)
    x, y, z = single(np.concatenate((left, right))).T
    i, j, k = _triangles(starts, len(arc))
    hover_data = np.column_stack((arc, thickness)) * MM_PER_M
    figure.add(
        'mesh3d', x=x, y=y, z=z, i=i, j=j, k=k,
        intensity=single(np.nan_to_num(np.tile(deviation, 2))),
        # One bar for all layers: that of a trace goes when its layer is not shown.
        coloraxis='coloraxis', name='measured', meta={'layer': layer},
        lighting={'ambient': 1, 'diffuse': 0, 'specular': 0, 'fresnel': 0},
        customdata=single(np.tile(hover_data, (2, 1))),
        hovertemplate='%{customdata[1]:.3f} mm at %{customdata[0]:.1f} mm<extra></extra>')


def _triangles(starts: NDArray[np.intp], count: int) -> NDArray[np.int32]:
    """Return the corners of the triangles that begin at these samples (S,), as (3, 2 S).

    Corners are numbered: first the left side points of ``count`` samples, then the right ones.
    """
    return np.concatenate((
        np.stack((starts, starts + count, starts + 1)),
        np.stack((starts + count, starts + count + 1, starts + 1))), axis=1).astype(np.int32)


def _add_unmeasured(figure: Figure, profile: ThicknessProfile) -> None:
    """Draw the path where nothing was measured, in the colours of the statuses."""
    drawn = on_map(profile)
    for status in sorted(set(Status) - {Status.MEASURED}):
        chosen = drawn & (profile.status == status)
        if chosen.any():
            x, y, z = single(pen_up(profile.points * MM_PER_M, chosen)).T
            colour = OCCLUDED_COLOUR if status == Status.OCCLUDED else STATUS_COLOURS[status]
            figure.add('scatter3d', x=x, y=y, z=z, mode='lines', name=label(status),
                       line={'color': colour, 'width': 5}, hoverinfo='name')


def _colours(reference_name: str) -> dict[str, Any]:
    """Return the scale of colours, and its bar."""
    return {'cmin': -PERCENT * FULL_COLOUR_DEVIATION, 'cmax': PERCENT * FULL_COLOUR_DEVIATION,
            'colorscale': ((0, TOO_THIN_COLOUR), (0.5, ON_TARGET_COLOUR), (1, TOO_THICK_COLOUR)),
            'colorbar': {'title': {'text': f'off the {reference_name}'}, 'ticksuffix': ' %',
                         'thickness': 12, 'orientation': 'h', 'y': 1, 'yanchor': 'bottom'}}


def _scene(profile: ThicknessProfile) -> dict[str, Any]:
    """Return axes, proportions and first point of view."""
    style = {'gridcolor': '#777777', 'showbackground': False, 'color': 'white'}
    return {'aspectmode': 'manual',
            'aspectratio': dict(zip('xyz', _proportions(profile).tolist(), strict=True)),
            'bgcolor': BACKGROUND_COLOUR, 'camera': {'eye': {'x': 0.0, 'y': -1.0, 'z': 1.6}},
            **{f'{name}axis': axis(f'{name} [mm]', **style) for name in 'xyz'}}


def _proportions(profile: ThicknessProfile) -> Array:
    """Return the sides of the scene (3,), in proportion to what is known of the filament.

    Plotly would make the volume 1, and what is flat very large.
    """
    points = np.concatenate((profile.points[on_map(profile)], profile.left_points,
                             profile.right_points))
    points = points[np.isfinite(points).all(axis=1)]
    sides = np.ptp(points, axis=0) if len(points) else np.ones(3)
    longest = float(sides.max()) or 1.0
    return np.maximum(1.3 * sides / longest, 0.01)
