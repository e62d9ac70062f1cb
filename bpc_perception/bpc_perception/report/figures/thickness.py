"""Thickness and height over arc length."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.result import Result
from bpc_perception.core.targets import WidthTargets
from bpc_perception.display.legend import (
    HEIGHT_COLOUR,
    STATUS_COLOURS,
    TARGET_COLOUR,
    WINDOW_COLOUR,
)
from bpc_perception.display.overlay import path_pixels
from bpc_perception.display.units import MM_PER_M
from bpc_perception.report.figures.data import thickness_range
from bpc_perception.report.figures.figure import Figure
from bpc_perception.report.figures.style import (
    axis,
    band_outline,
    FULL_HEIGHT_AXIS,
    reference_line,
    shade_statuses,
    single,
)


def thickness_figure(result: Result, targets: WidthTargets | None, dead_band: float) -> Figure:
    """Draw thickness over arc length; the stretches without one are shaded by status.

    The curve carries the pixels of the path, for the cursor in the image.

    Args:
        result: of a measured capture.
        targets: the thickness wanted along the path; None = none.
        dead_band: deviation, as a share of the target, in which nothing is corrected.
    """
    profile, advice = result.profile, result.advice
    assert profile is not None
    assert advice is not None
    figure = Figure()
    shade_statuses(figure, profile)
    _add_measured(figure, result)
    _add_height(figure, profile)
    if targets is not None:
        _add_target(figure, targets, profile.arc_length * MM_PER_M, dead_band)
    if np.isfinite(advice.window).all():
        start, end = np.multiply(advice.window, MM_PER_M)
        figure.add_shape('rect', x0=start, x1=end, y0=0, y1=0.03, yref='y domain',
                         name='advice window', showlegend=True, fillcolor=WINDOW_COLOUR,
                         line={'color': TARGET_COLOUR, 'width': 0.5})
    shown = {'range': thickness_range(profile, targets)}
    if not np.isfinite(profile.height + profile.height_sigma).any():
        return figure.lay_out(xaxis=axis('arc length [mm]'), yaxis2=FULL_HEIGHT_AXIS,
                              yaxis=axis('thickness [mm]', **shown))
    return figure.lay_out(
        xaxis=axis('arc length [mm]', anchor='y3'), yaxis2=FULL_HEIGHT_AXIS,
        yaxis=axis('thickness [mm]', domain=(0.38, 1), **shown),
        yaxis3=axis('height [mm]', domain=(0, 0.3), anchor='x', rangemode='tozero'))


def _add_measured(figure: Figure, result: Result) -> None:
    """Draw the thickness of the measured samples with one standard deviation."""
    profile = result.profile
    assert profile is not None
    arc, thickness, sigma = (values * MM_PER_M for values in (
        profile.arc_length, profile.thickness, profile.sigma))
    measured = profile.status == Status.MEASURED
    figure.add('scatter', **band_outline(arc, thickness - sigma, thickness + sigma), mode='lines',
               fill='toself', fillcolor=STATUS_COLOURS[Status.MEASURED], opacity=0.3,
               line={'width': 0}, name='± 1 sigma', hoverinfo='skip')
    figure.add(
        'scatter', x=single(arc), y=single(np.where(measured, thickness, np.nan)), mode='lines',
        name='thickness', line={'color': STATUS_COLOURS[Status.MEASURED], 'width': 1.5},
        customdata=single(np.column_stack((sigma, path_pixels(result, profile.feet)))),
        hovertemplate='%{y:.3f} ± %{customdata[0]:.3f} mm at %{x:.1f} mm<extra></extra>')


def _add_height(figure: Figure, profile: ThicknessProfile) -> None:
    """Draw the height of the ink with one standard deviation, where it is known."""
    arc, height, sigma = (values * MM_PER_M for values in (
        profile.arc_length, profile.height, profile.height_sigma))
    if not np.isfinite(height + sigma).any():
        return
    figure.add('scatter', **band_outline(arc, height - sigma, height + sigma), mode='lines',
               fill='toself', fillcolor=HEIGHT_COLOUR, opacity=0.3, line={'width': 0},
               yaxis='y3', showlegend=False, hoverinfo='skip')
    figure.add(
        'scatter', x=single(arc), y=single(np.where(np.isfinite(sigma), height, np.nan)),
        yaxis='y3', mode='lines', name='height', line={'color': HEIGHT_COLOUR, 'width': 1.5},
        customdata=single(sigma),
        hovertemplate='%{y:.3f} ± %{customdata:.3f} mm high at %{x:.1f} mm<extra></extra>')


def _add_target(figure: Figure, targets: WidthTargets, arc: Array, dead_band: float) -> None:
    """Draw the target and its dead band over arc lengths (N,) [mm]."""
    at, target = _target_corners(targets, arc)
    figure.add('scatter',
               **band_outline(at, target * (1 - dead_band), target * (1 + dead_band)),
               mode='lines', fill='toself', fillcolor=TARGET_COLOUR, opacity=0.15,
               line={'width': 0}, name='dead band', hoverinfo='skip')
    figure.add('scatter', x=at, y=target, mode='lines', name='target',
               line=reference_line('dash'), hovertemplate='%{y:.3f} mm wanted<extra></extra>')


def _target_corners(targets: WidthTargets, arc: Array) -> tuple[Array, Array]:
    """Return the corners of the target within arc lengths (N,) [mm]: where they are, how thick.

    Returns:
        (K,) arc lengths and (K,) thicknesses [mm]; K is 0 where N is.
    """
    if not len(arc):
        return np.empty(0), np.empty(0)
    rows = targets.arc_length * MM_PER_M
    inside = (rows > arc[0]) & (rows < arc[-1])
    at = np.concatenate((arc[:1], rows[inside], arc[-1:]))
    ends = targets.at(arc[[0, -1]] / MM_PER_M) * MM_PER_M
    return at, np.concatenate((ends[:1], targets.thickness[inside] * MM_PER_M, ends[1:]))
