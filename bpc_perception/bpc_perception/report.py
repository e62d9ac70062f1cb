"""The report of a measurement: one HTML file that opens anywhere, without a network."""

from __future__ import annotations

import base64
from datetime import datetime, timezone
from typing import Any

import cv2
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from bpc_perception.core.advice import RateAdvice
from bpc_perception.core.geometry import Array
from bpc_perception.core.profile import run_extents, Status, ThicknessProfile
from bpc_perception.core.session import Result
from bpc_perception.legend import (
    advice_in_words,
    COLOURS,
    label,
    LEFT,
    MEANINGS,
    RIGHT,
    TARGET,
    WINDOW,
)
from bpc_perception.overlay import path_pixels

MM = 1e3  # [mm/m]

def render(result: Result, summary: dict[str, Any]) -> str:
    """The page about a measured result.

    Args:
        result: with profile, advice and pose of the camera.
        summary: content of summary.json, lengths in mm.
    """
    profile, advice = result.profile, result.advice
    assert profile is not None
    assert advice is not None
    figures = {
        'image': image_figure(result),
        'thickness': thickness_figure(profile, advice, path_pixels(result, profile.points),
                                      float(summary['settings'].get('advice.dead_band', 0))),
        'histogram': histogram_figure(profile, advice),
    }
    environment = Environment(
        loader=PackageLoader('bpc_perception'), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True)
    environment.filters.update(number=_number, mm=_mm, utc=_utc)
    return environment.get_template('report.html.j2').render(
        summary=summary, advice_words=advice_in_words(advice),
        statuses=[(status.name, label(status), COLOURS[status], MEANINGS[status])
                  for status in Status],
        aspect=f'{result.capture.camera.width} / {result.capture.camera.height}',
        plotly=Markup(get_plotlyjs()),
        figures={name: _embed(name, figure) for name, figure in figures.items()})


def image_figure(result: Result) -> go.Figure:
    """The image with path and side points; pixel centres have integer coordinates.

    The last trace is an empty ring: the cursor that follows the pointer over the profile.
    """
    profile, camera = result.profile, result.capture.camera
    assert profile is not None
    figure = go.Figure(go.Image(source=_data_uri(result.capture.image), hoverinfo='skip'))
    path = path_pixels(result, profile.points)
    measured = profile.status == Status.MEASURED
    for status in Status:
        _add_points(figure, label(status), COLOURS[status], path, profile,
                    profile.status == status)
    for name, colour, points in (('left side', LEFT, profile.left_points),
                                 ('right side', RIGHT, profile.right_points)):
        _add_points(figure, name, colour, path_pixels(result, points), profile, measured)
    figure.add_scatter(x=[None], y=[None], mode='markers', showlegend=False, hoverinfo='skip',
                       marker={'symbol': 'circle-open', 'size': 18, 'color': WINDOW,
                               'line': {'width': 3}})
    return figure.update_layout(
        _layout(), dragmode='pan', margin={'l': 0, 'r': 0, 't': 30, 'b': 0},
        legend={'y': -0.01},
        xaxis={'range': (-0.5, camera.width - 0.5), 'visible': False, 'constrain': 'domain'},
        yaxis={'range': (camera.height - 0.5, -0.5), 'visible': False, 'constrain': 'domain',
               'scaleanchor': 'x'})


def _add_points(figure: go.Figure, name: str, colour: str, uv: Array, profile: ThicknessProfile,
                chosen: NDArray[np.bool_]) -> None:
    """Draw the chosen samples at these pixels (N, 2)."""
    if not chosen.any():
        return
    figure.add_scatter(
        x=uv[chosen, 0], y=uv[chosen, 1], mode='markers', name=name,
        marker={'color': colour, 'size': 5, 'line': {'color': 'white', 'width': 0.5}},
        customdata=np.stack((profile.arc_length, profile.thickness), axis=1)[chosen] * MM,
        hovertemplate='at %{customdata[0]:.1f} mm: %{customdata[1]:.3f} mm')


def thickness_figure(profile: ThicknessProfile, advice: RateAdvice, path: Array,
                     dead_band: float) -> go.Figure:
    """Thickness over arc length [mm]; the stretches without one shaded by status.

    The curve carries the pixels (N, 2) of the path, for the cursor in the image.
    """
    arc, thickness, sigma = (values * MM for values in (
        profile.arc_length, profile.thickness, profile.sigma))
    measured = profile.status == Status.MEASURED
    figure = go.Figure()
    for status in Status:
        if status != Status.MEASURED:
            _shade(figure, label(status), COLOURS[status],
                   run_extents(profile.status == status, arc))
    figure.add_scatter(**_band(arc, thickness - sigma, thickness + sigma), mode='lines',
                       fill='toself', fillcolor=COLOURS[Status.MEASURED], opacity=0.3,
                       line={'width': 0}, name='± 1 sigma', hoverinfo='skip')
    figure.add_scatter(
        x=arc, y=np.where(measured, thickness, np.nan), mode='lines', name='thickness',
        line={'color': COLOURS[Status.MEASURED], 'width': 1.5},
        customdata=np.column_stack((sigma, path)),
        hovertemplate='%{y:.3f} ± %{customdata[0]:.3f} mm at %{x:.1f} mm<extra></extra>')
    if advice.target_thickness > 0:
        target = advice.target_thickness * MM
        figure.add_hrect(target * (1 - dead_band), target * (1 + dead_band), name='dead band',
                         showlegend=True, fillcolor=TARGET, opacity=0.15, line={'width': 0})
        figure.add_hline(target, name='target', showlegend=True, line=_line('dash'))
    if np.isfinite(advice.window).all():
        start, end = np.multiply(advice.window, MM)
        figure.add_shape(type='rect', x0=start, x1=end, y0=0, y1=0.03, yref='y domain',
                         name='advice window', showlegend=True, fillcolor=WINDOW,
                         line={'color': TARGET, 'width': 0.5})
    return figure.update_layout(
        _layout(), xaxis={'title': 'arc length [mm]'},
        yaxis={'title': 'thickness [mm]', 'range': (0, _ceiling(profile, advice))})


def _ceiling(profile: ThicknessProfile, advice: RateAdvice) -> float:
    """Up to where thickness is shown at first [mm]: outliers must not flatten all the rest."""
    usual = np.fmax(profile.summary.thickness_median, advice.target_thickness)
    if not usual > 0:
        return 1.0
    highest = np.nanmax(np.append(profile.thickness + np.nan_to_num(profile.sigma), usual))
    return 1.1 * MM * float(min(highest, 2 * usual))


def _band(x: Array, low: Array, high: Array) -> dict[str, Array]:
    """The outline between low and high (N,), one closed piece for each run without NaN."""
    known = np.isfinite(low + high)
    outline = [np.empty((2, 0))]
    for run in np.split(np.arange(len(x)), np.flatnonzero(np.diff(known)) + 1):
        if known[run].any():
            back = run[::-1]
            outline += [np.stack((x[run], low[run])), np.stack((x[back], high[back])),
                        np.full((2, 1), np.nan)]
    return dict(zip('xy', np.concatenate(outline, axis=1), strict=True))


def _shade(figure: go.Figure, name: str, colour: str, extents: Array) -> None:
    """Shade stretches (N, 2) of the x axis, under one name."""
    for index, (start, end) in enumerate(extents):
        figure.add_vrect(start, end, name=name, legendgroup=name, showlegend=index == 0,
                         fillcolor=colour, opacity=0.25, line={'width': 0}, layer='below')


def histogram_figure(profile: ThicknessProfile, advice: RateAdvice) -> go.Figure:
    """How often each thickness [mm] was measured, and its quartiles."""
    summary, measured = profile.summary, profile.status == Status.MEASURED
    widths, ceiling = profile.thickness[measured] * MM, _ceiling(profile, advice)
    low = 0.95 * float(widths.min(initial=ceiling))
    figure = go.Figure(go.Histogram(
        x=widths, xbins={'start': low, 'size': (ceiling - low) / 40}, name='measured',
        marker={'color': COLOURS[Status.MEASURED]}, opacity=0.6,
        hovertemplate='%{x} mm: %{y} samples<extra></extra>'))
    for name, value, dash in (('first quartile', summary.thickness_q1, 'dot'),
                              ('median', summary.thickness_median, 'solid'),
                              ('third quartile', summary.thickness_q3, 'dot'),
                              ('target', advice.target_thickness, 'dash')):
        if np.isfinite(value):
            figure.add_vline(value * MM, name=f'{name} {value * MM:.3f} mm', showlegend=True,
                             line=_line(dash))
    return figure.update_layout(
        _layout(), bargap=0.02, yaxis={'title': 'samples', 'fixedrange': True},
        xaxis={'title': 'thickness [mm]', 'range': (low, ceiling)})


def _line(dash: str) -> dict[str, Any]:
    return {'color': TARGET, 'width': 1.5, 'dash': dash}


def _layout() -> dict[str, Any]:
    return {
        'template': 'plotly_white', 'autosize': True, 'showlegend': True, 'hovermode': 'closest',
        'font': {'family': 'system-ui, sans-serif', 'size': 13},
        'margin': {'l': 55, 'r': 10, 't': 40, 'b': 50},
        'legend': {'orientation': 'h', 'yanchor': 'top', 'y': -0.2, 'x': 0,
                   'itemsizing': 'constant'},
    }


def _embed(name: str, figure: go.Figure) -> Markup:
    """The figure as HTML that fills the element around it."""
    html = figure.to_html(
        full_html=False, include_plotlyjs=False, div_id=f'{name}-figure',
        default_width='100%', default_height='100%',
        # Plotly has a button that uploads the data; measurements stay where they are.
        config={'showSendToCloud': False, 'displaylogo': False,
                'modeBarButtonsToRemove': ['select2d', 'lasso2d'],
                'responsive': True, 'scrollZoom': name == 'image'})
    return Markup(html)


def _data_uri(image: NDArray[np.uint8]) -> str:
    """An RGB image (H, W, 3) as a JPEG of full colour resolution."""
    _, encoded = cv2.imencode('.jpg', cv2.cvtColor(image, cv2.COLOR_RGB2BGR), (
        cv2.IMWRITE_JPEG_QUALITY, 95,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444))
    return f'data:image/jpeg;base64,{base64.b64encode(encoded.tobytes()).decode()}'


def _number(value: float | None, digits: int = 3) -> str:
    """A number of the summary for reading; a dash for none."""
    return '-' if value is None else f'{value:.{digits}f}'


def _mm(value: float | None, digits: int = 3) -> str:
    return '-' if value is None else f'{value:.{digits}f} mm'


def _utc(stamp_ns: int) -> str:
    """A stamp as date and time of day, to the millisecond."""
    seconds, rest = divmod(stamp_ns, 10**9)
    moment = datetime.fromtimestamp(seconds, timezone.utc)
    return f'{moment:%Y-%m-%d %H:%M:%S}.{rest // 10**6:03d} UTC'
