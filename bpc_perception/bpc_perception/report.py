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

from bpc_perception.core.advice import RateAdvice, Reason
from bpc_perception.core.geometry import Array, invert, transform
from bpc_perception.core.profile import run_extents, Status, ThicknessProfile
from bpc_perception.core.session import Result

MM = 1e3  # [mm/m]

# The palette of Okabe and Ito, which colour-blind eyes can tell apart, and a grey.
COLOURS = {
    Status.MEASURED: '#0072B2',
    Status.GAP: '#D55E00',
    Status.NO_DATA: '#8C8C8C',
    Status.OCCLUDED: '#000000',
    Status.JUNCTION: '#CC79A7',
    Status.LOW_CONFIDENCE: '#E69F00',
}
LEFT, RIGHT, WINDOW, TARGET = '#56B4E9', '#009E73', '#F0E442', '#333333'
MEANINGS = {
    Status.MEASURED: 'a thickness, with its uncertainty',
    Status.GAP: 'the bed is seen and carries no ink',
    Status.NO_DATA: 'outside the image, no depth, or glare',
    Status.OCCLUDED: 'something stands in front, such as the nozzle',
    Status.JUNCTION: 'the path crosses or touches itself; no single width',
    Status.LOW_CONFIDENCE: 'seen, but not well enough to give a number',
}
REASONS = {
    Reason.ON_TARGET: 'on target',
    Reason.UNDER_EXTRUSION: 'the filament is too thin',
    Reason.OVER_EXTRUSION: 'the filament is too thick',
    Reason.LIMITED: 'limited to the largest change allowed',
    Reason.NOT_ENOUGH_DATA: 'not enough data',
    Reason.GAP_DETECTED: 'gap detected',
    Reason.STALE_DATA: 'the newest measurement is too old',
    Reason.NO_TARGET: 'no target thickness set',
}


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
        'thickness': thickness_figure(profile, advice, summary['settings']),
        'histogram': histogram_figure(profile, advice),
    }
    environment = Environment(
        loader=PackageLoader('bpc_perception'), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True)
    environment.filters.update(number=_number, utc=_utc)
    return environment.get_template('report.html.j2').render(
        summary=summary, advice_words=advice_in_words(advice),
        statuses=[(status.name, label(status), COLOURS[status], MEANINGS[status])
                  for status in Status],
        aspect=f'{result.capture.camera.width} / {result.capture.camera.height}',
        plotly=Markup(get_plotlyjs()),
        figures={name: _embed(name, figure) for name, figure in figures.items()})


def advice_in_words(advice: RateAdvice) -> str:
    """What to do, and why."""
    reason = REASONS[advice.reason]
    if not advice.valid or advice.reason == Reason.ON_TARGET:
        return f'change nothing: {reason}'
    return (f'flow x {advice.flow_rate_scale:.2f}, or else speed x {advice.speed_scale:.2f}: '
            f'{reason}')


def label(status: Status) -> str:
    """The name of a status in words."""
    return status.name.replace('_', ' ').lower()


def image_figure(result: Result) -> go.Figure:
    """The image with path and side points; pixel centres have integer coordinates."""
    profile, camera = result.profile, result.capture.camera
    assert profile is not None
    assert result.T_base_camera is not None
    T_camera_base = invert(result.T_base_camera)

    def pixels(points: Array) -> Array:
        return camera.pixels(transform(T_camera_base, points))

    figure = go.Figure(go.Image(source=_data_uri(result.capture.image), hoverinfo='skip'))
    path = pixels(profile.points)
    measured = profile.status == Status.MEASURED
    for name, colour, points in (('left side', LEFT, profile.left_points),
                                 ('right side', RIGHT, profile.right_points)):
        _add_points(figure, name, colour, pixels(points), profile, measured, size=4)
    for status in Status:
        _add_points(figure, label(status), COLOURS[status], path, profile,
                    profile.status == status, size=6 if status == Status.GAP else 4)
    return figure.update_layout(
        _layout(), dragmode='pan', margin={'l': 0, 'r': 0, 't': 0, 'b': 0},
        xaxis={'range': (-0.5, camera.width - 0.5), 'visible': False, 'constrain': 'domain'},
        yaxis={'range': (camera.height - 0.5, -0.5), 'visible': False, 'constrain': 'domain',
               'scaleanchor': 'x'})


def _add_points(figure: go.Figure, name: str, colour: str, uv: Array, profile: ThicknessProfile,
                chosen: NDArray[np.bool_], size: int) -> None:
    """Draw the chosen samples at these pixels (N, 2)."""
    if not chosen.any():
        return
    figure.add_scatter(
        x=uv[chosen, 0], y=uv[chosen, 1], mode='markers', name=name,
        marker={'color': colour, 'size': size},
        customdata=np.stack((profile.arc_length, profile.thickness), axis=1)[chosen] * MM,
        hovertemplate='at %{customdata[0]:.1f} mm: %{customdata[1]:.3f} mm')


def thickness_figure(profile: ThicknessProfile, advice: RateAdvice,
                     settings: dict[str, Any]) -> go.Figure:
    """Thickness over arc length [mm]; the stretches without one shaded by status."""
    arc, thickness, sigma = (values * MM for values in (
        profile.arc_length, profile.thickness, profile.sigma))
    target = advice.target_thickness * MM
    measured = profile.status == Status.MEASURED
    top = 1.15 * float(np.max([target if target > 0 else 1.0,
                               *(thickness + sigma)[measured]]))
    figure = go.Figure()
    for status in Status:
        extents = run_extents(profile.status == status, arc)
        if status != Status.MEASURED and len(extents):
            _add_areas(figure, label(status), COLOURS[status], [
                ((start, start, end, end), (0, top, top, 0)) for start, end in extents])
    runs = [run for run in np.split(np.arange(len(arc)),
                                    np.flatnonzero(np.diff(measured)) + 1)
            if len(run) and measured[run[0]]]
    _add_areas(figure, '± 1 sigma', COLOURS[Status.MEASURED], [
        (np.concatenate((arc[run], arc[run][::-1])),
         np.concatenate(((thickness + sigma)[run], (thickness - sigma)[run][::-1])))
        for run in runs])
    figure.add_scatter(
        x=arc, y=np.where(measured, thickness, np.nan), mode='lines', name='thickness',
        line={'color': COLOURS[Status.MEASURED], 'width': 1.5}, customdata=sigma,
        hovertemplate='%{y:.3f} ± %{customdata:.3f} mm at %{x:.1f} mm<extra></extra>')
    if target > 0:
        half = target * float(settings.get('advice.dead_band', 0.0))
        _add_areas(figure, 'target ± dead band', TARGET, [
            ((arc[0], arc[0], arc[-1], arc[-1]),
             (target - half, target + half, target + half, target - half))])
        figure.add_hline(target, line={'color': TARGET, 'width': 1, 'dash': 'dash'})
    if np.isfinite(advice.window).all():
        start, end = np.multiply(advice.window, MM)
        figure.add_shape(type='rect', x0=start, x1=end, y0=0.97, y1=1, yref='y domain',
                         fillcolor=WINDOW, line={'color': TARGET, 'width': 0.5})
        figure.add_annotation(x=(start + end) / 2, y=1, yref='y domain', yanchor='bottom',
                              text='advice window', showarrow=False)
    return figure.update_layout(
        _layout(), xaxis={'title': 'arc length [mm]'},
        yaxis={'title': 'thickness [mm]', 'range': (0, top), 'fixedrange': True})


def _add_areas(figure: go.Figure, name: str, colour: str,
               outlines: list[tuple[Any, Any]]) -> None:
    """Fill closed outlines, given as (x, y), all under one name."""
    separator = (np.nan,)
    x, y = ([value for outline in outlines for value in (*outline[axis], *separator)]
            for axis in (0, 1))
    figure.add_scatter(x=x, y=y, mode='lines', fill='toself', name=name, hoverinfo='skip',
                       line={'width': 0}, fillcolor=_faded(colour))


def histogram_figure(profile: ThicknessProfile, advice: RateAdvice) -> go.Figure:
    """How often each thickness [mm] was measured, and its quartiles."""
    summary = profile.summary
    figure = go.Figure(go.Histogram(
        x=profile.thickness[profile.status == Status.MEASURED] * MM, nbinsx=40,
        marker={'color': COLOURS[Status.MEASURED]}, opacity=0.6,
        hovertemplate='%{x} mm: %{y} samples<extra></extra>'))
    for name, value, dash, height in (
            ('Q1', summary.thickness_q1, 'dot', 1.0),
            ('median', summary.thickness_median, 'solid', 1.07),
            ('Q3', summary.thickness_q3, 'dot', 1.0),
            ('target', advice.target_thickness, 'dash', 1.14)):
        if np.isfinite(value):
            figure.add_vline(value * MM, line={'color': TARGET, 'width': 1.5, 'dash': dash})
            figure.add_annotation(x=value * MM, y=height, yref='y domain', yanchor='bottom',
                                  text=name, showarrow=False)
    return figure.update_layout(
        _layout(), showlegend=False, bargap=0.02, xaxis={'title': 'thickness [mm]'},
        yaxis={'title': 'samples', 'fixedrange': True})


def _layout() -> dict[str, Any]:
    return {
        'template': 'plotly_white', 'autosize': True, 'showlegend': True, 'hovermode': 'closest',
        'font': {'family': 'system-ui, sans-serif', 'size': 13},
        'margin': {'l': 55, 'r': 10, 't': 50, 'b': 50},
        'legend': {'orientation': 'h', 'yanchor': 'top', 'y': -0.15, 'x': 0,
                   'itemsizing': 'constant'},
    }


def _embed(name: str, figure: go.Figure) -> Markup:
    """The figure as HTML that fills the element around it."""
    html = figure.to_html(
        full_html=False, include_plotlyjs=False, div_id=f'{name}-figure',
        default_width='100%', default_height='100%',
        config={'responsive': True, 'displaylogo': False, 'scrollZoom': name == 'image'})
    return Markup(html)


def _data_uri(image: NDArray[np.uint8]) -> str:
    """An RGB image (H, W, 3) as a JPEG of full colour resolution."""
    _, encoded = cv2.imencode('.jpg', cv2.cvtColor(image, cv2.COLOR_RGB2BGR), (
        cv2.IMWRITE_JPEG_QUALITY, 95,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444))
    return f'data:image/jpeg;base64,{base64.b64encode(encoded.tobytes()).decode()}'


def _faded(colour: str) -> str:
    """A translucent colour of #RRGGBB."""
    red, green, blue = (int(colour[start:start + 2], 16) for start in (1, 3, 5))
    return f'rgba({red}, {green}, {blue}, 0.25)'


def _number(value: float | None, digits: int = 3) -> str:
    """A number of the summary for reading; a dash for none."""
    return '-' if value is None else f'{value:.{digits}f}'


def _utc(stamp_ns: int) -> str:
    """A stamp as date and time of day, to the millisecond."""
    seconds, rest = divmod(stamp_ns, 10**9)
    moment = datetime.fromtimestamp(seconds, timezone.utc)
    return f'{moment:%Y-%m-%d %H:%M:%S}.{rest // 10**6:03d} UTC'
