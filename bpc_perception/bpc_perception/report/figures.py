"""The figures of the report, interactive: lengths in millimetres.

Lines rather than markers wherever there are as many points as samples: a browser keeps one element
for a line, and one each for markers. Numbers are single precision, which half the page is made of.
"""

from __future__ import annotations

import base64
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
import plotly.graph_objects as go

from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import run_extents, Status, ThicknessProfile
from bpc_perception.core.session import Result
from bpc_perception.display.legend import (
    COLOURS,
    FULL,
    LEFT,
    RIGHT,
    RIGHT_ON,
    TARGET,
    THICK,
    THIN,
    WINDOW,
)
from bpc_perception.display.overlay import path_pixels
from bpc_perception.display.wording import label
from bpc_perception.report.uniformity import reference

MM = 1e3  # [mm/m]
SPACE = '#4D4D4D'  # behind the filament in 3-D, where THIN, RIGHT_ON and THICK all show
BINS = 40  # of the histogram
MAP_SAMPLES = 4000  # at most, in 3-D
SIDES = ('left side', 'right side')
IMAGE_BYTES = 600_000  # of the capture's image, unless its quality gets very low
QUALITIES = (95, 90, 80, 70, 60)  # of JPEG


def image_figure(result: Result) -> go.Figure:
    """The image with path and side points; pixel centres have integer coordinates.

    The last trace is an empty ring: the cursor that follows the pointer over the profile.
    """
    profile, camera = result.profile, result.capture.camera
    assert profile is not None
    figure = go.Figure()
    path = path_pixels(result, profile.points)
    for status in Status:
        _add_runs(figure, label(status), COLOURS[status], path, profile,
                  profile.status == status)
    measured = profile.status == Status.MEASURED
    for name, colour, points in ((SIDES[0], LEFT, profile.left_points),
                                 (SIDES[1], RIGHT, profile.right_points)):
        _add_runs(figure, name, colour, path_pixels(result, points), profile, measured)
    figure.add_scatter(x=[None], y=[None], mode='markers', showlegend=False, hoverinfo='skip',
                       marker={'symbol': 'circle-open', 'size': 18, 'color': WINDOW,
                               'line': {'width': 3}})
    figure.add_layout_image(
        source=jpeg_uri(result.capture.image), xref='x', yref='y', x=-0.5, y=-0.5, layer='below',
        sizex=camera.width, sizey=camera.height, sizing='stretch')
    return figure.update_layout(
        layout(), dragmode='pan', margin={'l': 0, 'r': 0, 't': 30, 'b': 0},
        legend={'y': -0.01},
        xaxis={'range': (-0.5, camera.width - 0.5), 'visible': False, 'constrain': 'domain'},
        yaxis={'range': (camera.height - 0.5, -0.5), 'visible': False, 'constrain': 'domain',
               'scaleanchor': 'x'})


def _add_runs(figure: go.Figure, name: str, colour: str, uv: Array, profile: ThicknessProfile,
              chosen: NDArray[np.bool_]) -> None:
    """Draw the chosen samples at these pixels (N, 2), each half-way to its neighbours.

    Where the pointer is over the path the place and the thickness are told.
    """
    if not chosen.any():
        return
    if name in SIDES:
        x, y = pen_up(uv, chosen).T.astype(np.float32)
        figure.add_scatter(x=x, y=y, mode='lines', name=name, hoverinfo='skip',
                           line={'color': colour, 'width': 2.5})
        return
    tip = np.column_stack((uv, profile.arc_length * MM, profile.thickness * MM))
    x, y, *told = pen_up(tip, chosen).T.astype(np.float32)
    figure.add_scatter(x=x, y=y, mode='lines', name=name, line={'color': colour, 'width': 2.5},
                       customdata=np.stack(told, axis=1),
                       hovertemplate='at %{customdata[0]:.1f} mm: %{customdata[1]:.3f} mm')


def pen_up(values: Array, chosen: NDArray[np.bool_]) -> Array:
    """Rows (M, K) of values (N, K) along a line through the chosen samples.

    A row of NaN parts the runs. Each run goes on half-way to its neighbours, as far as these are
    known, so that a single sample can be seen.
    """
    middles = (values[1:] + values[:-1]) / 2
    nothing = np.full((1, values.shape[1]), np.nan)
    parts = []
    for start, end in np.flatnonzero(np.diff(np.concatenate(
            ([False], chosen, [False])).astype(np.int8))).reshape(-1, 2):
        parts += [known for known in (middles[start - 1:start] if start else nothing[:0],
                                      values[start:end], middles[end - 1:end])
                  if np.isfinite(known[:, :2]).any()]
        parts.append(nothing)
    return np.concatenate(parts) if parts else nothing[:0]


def thickness_figure(result: Result, targets: WidthTargets | None, dead_band: float) -> go.Figure:
    """Thickness over arc length; the stretches without one shaded by status.

    The curve carries the pixels of the path, for the cursor in the image.
    """
    profile, advice = result.profile, result.advice
    assert profile is not None
    assert advice is not None
    arc, thickness, sigma = (values * MM for values in (
        profile.arc_length, profile.thickness, profile.sigma))
    measured = profile.status == Status.MEASURED
    figure = go.Figure()
    _shade_statuses(figure, profile)
    figure.add_scatter(**_band(arc, thickness - sigma, thickness + sigma), mode='lines',
                       fill='toself', fillcolor=COLOURS[Status.MEASURED], opacity=0.3,
                       line={'width': 0}, name='± 1 sigma', hoverinfo='skip')
    figure.add_scatter(
        x=_single(arc), y=_single(np.where(measured, thickness, np.nan)), mode='lines',
        name='thickness', line={'color': COLOURS[Status.MEASURED], 'width': 1.5},
        customdata=_single(np.column_stack((sigma, path_pixels(result, profile.points)))),
        hovertemplate='%{y:.3f} ± %{customdata[0]:.3f} mm at %{x:.1f} mm<extra></extra>')
    if targets is not None:
        at, wanted = _corners(targets, arc)
        figure.add_scatter(**_band(at, wanted * (1 - dead_band), wanted * (1 + dead_band)),
                           mode='lines', fill='toself', fillcolor=TARGET, opacity=0.15,
                           line={'width': 0}, name='dead band', hoverinfo='skip')
        figure.add_scatter(x=at, y=wanted, mode='lines', name='target', line=_line('dash'),
                           hovertemplate='%{y:.3f} mm wanted<extra></extra>')
    if np.isfinite(advice.window).all():
        start, end = np.multiply(advice.window, MM)
        figure.add_shape(type='rect', x0=start, x1=end, y0=0, y1=0.03, yref='y domain',
                         name='advice window', showlegend=True, fillcolor=WINDOW,
                         line={'color': TARGET, 'width': 0.5})
    return figure.update_layout(
        layout(), xaxis={'title': 'arc length [mm]'}, yaxis2=OVER_ALL,
        yaxis={'title': 'thickness [mm]', 'range': (0, ceiling(profile, targets))})


def _corners(targets: WidthTargets, arc: Array) -> tuple[Array, Array]:
    """Arc lengths [mm] of the corners of the target within arc (N,) [mm], and what is wanted."""
    if not len(arc):
        return np.empty(0), np.empty(0)
    rows = targets.arc_length * MM
    inside = (rows > arc[0]) & (rows < arc[-1])
    at = np.concatenate((arc[:1], rows[inside], arc[-1:]))
    ends = targets.at(arc[[0, -1]] / MM) * MM
    return at, np.concatenate((ends[:1], targets.thickness[inside] * MM, ends[1:]))


def offset_figure(profile: ThicknessProfile) -> go.Figure:
    """How far the deposit's middle lies to the left of the path, over arc length."""
    arc, offset = profile.arc_length * MM, (profile.left - profile.right) / 2 * MM
    figure = go.Figure()
    _shade_statuses(figure, profile)
    figure.add_scatter(x=_single(arc), y=_single(offset), mode='lines', name='offset',
                       line={'color': COLOURS[Status.MEASURED], 'width': 1.5},
                       hovertemplate='%{y:+.3f} mm at %{x:.1f} mm<extra></extra>')
    figure.add_hline(0, line={'color': TARGET, 'width': 1})
    return figure.update_layout(
        layout(), xaxis={'title': 'arc length [mm]'}, yaxis2=OVER_ALL, legend={'y': -0.35},
        yaxis={'title': 'left of the path [mm]', 'range': offset_range(profile)})


def offset_range(profile: ThicknessProfile) -> tuple[float, float]:
    """Between which offsets are shown at first [mm]: without outliers, and no mere noise."""
    offset = np.abs(np.append(profile.left - profile.right, 0.0)) / 2 * MM
    largest = 1.5 * max(float(np.nanpercentile(offset, 99)), 0.05)
    return -largest, largest


def map_figure(profile: ThicknessProfile, targets: WidthTargets | None) -> go.Figure:
    """The filament in the base frame, as wide as measured, coloured by its deviation."""
    figure = go.Figure()
    # Of a long print each second sample, or third and so on.
    shown = slice(None, None, -(-len(profile) // MAP_SAMPLES) or 1)
    path, thickness, arc = (each[shown] for each in (
        profile.points, profile.thickness, profile.arc_length))
    sides = [points[shown] for points in (profile.left_points, profile.right_points)]
    measured = (profile.status[shown] == Status.MEASURED) & np.isfinite(
        sides[0] + sides[1]).all(axis=1)
    left, right = (np.where(measured[:, None], points, path) * MM for points in sides)
    starts = np.flatnonzero(measured[:-1] & measured[1:])
    if len(starts):
        off = 100 * (thickness / reference(profile, targets)[shown] - 1)
        count = len(path)
        x, y, z = _single(np.concatenate((left, right))).T
        i, j, k = np.concatenate((
            np.stack((starts, starts + count, starts + 1)),
            np.stack((starts + count, starts + count + 1, starts + 1))), axis=1).astype(np.int32)
        told = np.column_stack((arc, thickness)) * MM
        figure.add_mesh3d(
            x=x, y=y, z=z, i=i, j=j, k=k, intensity=_single(np.nan_to_num(np.tile(off, 2))),
            cmin=-100 * FULL, cmax=100 * FULL,
            colorscale=((0, THIN), (0.5, RIGHT_ON), (1, THICK)), name='measured',
            lighting={'ambient': 1, 'diffuse': 0, 'specular': 0, 'fresnel': 0},
            colorbar={'title': {'text': 'off the ' + ('median' if targets is None else 'target')},
                      'ticksuffix': ' %', 'thickness': 12, 'orientation': 'h', 'y': 1,
                      'yanchor': 'bottom'},
            customdata=_single(np.tile(told, (2, 1))),
            hovertemplate='%{customdata[1]:.3f} mm at %{customdata[0]:.1f} mm<extra></extra>')
    for status in Status:
        chosen = profile.status == status
        if status != Status.MEASURED and chosen.any():
            x, y, z = _single(pen_up(profile.points * MM, chosen)).T
            # Black would not show on the grey.
            colour = 'white' if status == Status.OCCLUDED else COLOURS[status]
            figure.add_scatter3d(x=x, y=y, z=z, mode='lines', name=label(status),
                                 line={'color': colour, 'width': 5}, hoverinfo='name')
    return figure.update_layout(
        layout(), margin={'l': 20, 'r': 20, 't': 70, 'b': 0}, legend={'y': 0},
        scene={'aspectmode': 'manual',
               'aspectratio': dict(zip('xyz', _sides(profile), strict=True)),
               'bgcolor': SPACE, 'camera': {'eye': {'x': 0.0, 'y': -1.0, 'z': 1.6}},
               **{f'{axis}axis': {'title': {'text': f'{axis} [mm]'}, 'gridcolor': '#777777',
                                  'showbackground': False, 'color': 'white'} for axis in 'xyz'}})


def _sides(profile: ThicknessProfile) -> list[float]:
    """Length, width and height of the filament in proportion, as far as anything is measured.

    Not left to Plotly, which makes the volume 1, and what is flat very large.
    """
    points = np.concatenate((profile.points, profile.left_points, profile.right_points))
    points = points[np.isfinite(points).all(axis=1)]
    sides = np.ptp(points, axis=0) if len(points) else np.ones(3)
    longest = float(sides.max()) or 1.0
    return np.maximum(1.3 * sides / longest, 0.01).tolist()


def histogram_figure(profile: ThicknessProfile, targets: WidthTargets | None) -> go.Figure:
    """How often each thickness was measured, and its quartiles."""
    summary, measured = profile.summary, profile.status == Status.MEASURED
    widths, top = profile.thickness[measured] * MM, ceiling(profile, targets)
    low = 0.95 * float(widths.min(initial=top))
    figure = go.Figure(go.Histogram(
        x=_single(widths), xbins={'start': low, 'size': (top - low) / BINS}, name='measured',
        marker={'color': COLOURS[Status.MEASURED]}, opacity=0.6,
        hovertemplate='%{x} mm: %{y} samples<extra></extra>'))
    lines = [('first quartile', summary.thickness_q1, 'dot'),
             ('median', summary.thickness_median, 'solid'),
             ('third quartile', summary.thickness_q3, 'dot')]
    if targets is not None and np.ptp(targets.thickness) == 0:
        lines.append(('target', float(targets.thickness[0]), 'dash'))
    for name, value, dash in lines:
        if np.isfinite(value):
            figure.add_vline(value * MM, name=f'{name} {value * MM:.3f} mm', showlegend=True,
                             line=_line(dash))
    return figure.update_layout(
        layout(), bargap=0.02, yaxis={'title': 'samples', 'fixedrange': True},
        xaxis={'title': 'thickness [mm]', 'range': (low, top)})


def ceiling(profile: ThicknessProfile, targets: WidthTargets | None) -> float:
    """Up to where thickness is shown at first [mm]: outliers must not flatten all the rest."""
    wanted = 0.0 if targets is None else float(targets.thickness.max())
    usual = np.fmax(profile.summary.thickness_median, wanted)
    if not usual > 0:
        return 1.0
    highest = np.nanmax(np.append(profile.thickness + np.nan_to_num(profile.sigma), usual))
    return 1.1 * MM * float(min(highest, 2 * usual))


def _single(values: Array) -> NDArray[np.float32]:
    return values.astype(np.float32)


def _band(x: Array, low: Array, high: Array) -> dict[str, NDArray[np.float32]]:
    """The outline between low and high (N,), one closed piece for each run without NaN."""
    known = np.isfinite(low + high)
    outline = [np.empty((2, 0))]
    for run in np.split(np.arange(len(x)), np.flatnonzero(np.diff(known)) + 1):
        if known[run].any():
            back = run[::-1]
            outline += [np.stack((x[run], low[run])), np.stack((x[back], high[back])),
                        np.full((2, 1), np.nan)]
    return dict(zip('xy', _single(np.concatenate(outline, axis=1)), strict=True))


# An axis from 0 to 1 over the whole height, for what is shaded.
OVER_ALL: dict[str, Any] = {'overlaying': 'y', 'range': (0, 1), 'fixedrange': True,
                            'visible': False}


def _shade_statuses(figure: go.Figure, profile: ThicknessProfile) -> None:
    """Shade the stretches without a thickness, by status, on the axis OVER_ALL."""
    for status in Status:
        if status != Status.MEASURED and (profile.status == status).any():
            figure.add_scatter(**_stretches(run_extents(
                profile.status == status, profile.arc_length * MM)), yaxis='y2', mode='lines',
                fill='toself', fillcolor=COLOURS[status], opacity=0.25, line={'width': 0},
                name=label(status), hoverinfo='skip')


def _stretches(extents: Array) -> dict[str, NDArray[np.float32]]:
    """Outlines of stretches (R, 2) of the x axis, from 0 to 1."""
    start, end = extents.T
    nan = np.full(len(extents), np.nan)
    x = np.stack((start, start, end, end, nan), axis=1)
    y = np.broadcast_to((0.0, 1.0, 1.0, 0.0, np.nan), x.shape)
    return {'x': _single(x.ravel()), 'y': _single(y.ravel())}


def _line(dash: str) -> dict[str, Any]:
    return {'color': TARGET, 'width': 1.5, 'dash': dash}


def layout() -> dict[str, Any]:
    """What all figures have in common."""
    return {
        'template': 'plotly_white', 'autosize': True, 'showlegend': True, 'hovermode': 'closest',
        'font': {'family': 'system-ui, sans-serif', 'size': 13},
        'margin': {'l': 55, 'r': 10, 't': 40, 'b': 50},
        'legend': {'orientation': 'h', 'yanchor': 'top', 'y': -0.2, 'x': 0,
                   'itemsizing': 'constant'},
    }


def jpeg_uri(image: NDArray[np.uint8]) -> str:
    """An RGB image (H, W, 3) as a JPEG of full colour resolution, of IMAGE_BYTES if possible."""
    turned = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    for quality in QUALITIES:
        _, encoded = cv2.imencode('.jpg', turned, (
            cv2.IMWRITE_JPEG_QUALITY, quality,
            cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444))
        if len(encoded) <= IMAGE_BYTES:
            break
    return data_uri(encoded.tobytes(), 'jpeg')


def data_uri(data: bytes, kind: str) -> str:
    """A picture as an address that holds it."""
    return f'data:image/{kind};base64,{base64.b64encode(data).decode()}'
