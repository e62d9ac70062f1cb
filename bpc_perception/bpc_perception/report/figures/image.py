"""The camera's image with path and side points."""

from __future__ import annotations

import base64

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.result import Result
from bpc_perception.display.layers import layers_of
from bpc_perception.display.legend import (
    as_shown,
    LEFT_COLOUR,
    RIGHT_COLOUR,
    STATUS_COLOURS,
    WINDOW_COLOUR,
)
from bpc_perception.display.overlay import path_pixels
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.wording import label
from bpc_perception.report.figures.data import pen_up
from bpc_perception.report.figures.figure import Figure

MOST_IMAGE_BYTES = 600_000  # unless the quality would get lower than the last of these
JPEG_QUALITIES = (95, 90, 80, 70, 60)
LINE_WIDTH_PX = 2.5


def image_figure(result: Result) -> Figure:
    """Draw the image with path and side points; pixel centres have integer coordinates.

    The last trace is an empty ring: the cursor that follows the pointer over the profile.
    """
    profile, camera = result.profile, result.capture.camera
    assert profile is not None
    figure = Figure(legend_y=-0.01)
    path, profile = path_pixels(result, profile.feet), as_shown(profile)
    sides = (('left side', LEFT_COLOUR, path_pixels(result, profile.left_points)),
             ('right side', RIGHT_COLOUR, path_pixels(result, profile.right_points)))
    for layer, own in layers_of(profile):
        for status in Status:
            _add_path(figure, status, path, profile, layer, own)
        measured = own & (profile.status == Status.MEASURED)
        for name, colour, uv in sides:
            _add_side(figure, name, colour, uv, measured, layer)
    _show_once(figure)
    figure.add('scatter', x=[None], y=[None], mode='markers', showlegend=False, hoverinfo='skip',
               marker={'symbol': 'circle-open', 'size': 18, 'color': WINDOW_COLOUR,
                       'line': {'width': 3}})
    return figure.lay_out(
        dragmode='pan', margin={'l': 0, 'r': 0, 't': 30, 'b': 0},
        images=[{'source': jpeg_uri(result.capture.image), 'xref': 'x', 'yref': 'y', 'x': -0.5,
                 'y': -0.5, 'layer': 'below', 'sizex': camera.width, 'sizey': camera.height,
                 'sizing': 'stretch'}],
        xaxis={'range': (-0.5, camera.width - 0.5), 'visible': False, 'constrain': 'domain'},
        yaxis={'range': (camera.height - 0.5, -0.5), 'visible': False, 'constrain': 'domain',
               'scaleanchor': 'x'})


def _show_once(figure: Figure) -> None:
    """Show what has the same name in several layers once in the legend."""
    seen: set[str] = set()
    for trace in figure.traces:
        trace |= {'legendgroup': trace['name'], 'showlegend': trace['name'] not in seen}
        seen.add(trace['name'])


def _add_path(figure: Figure, status: Status, uv: Array, profile: ThicknessProfile,
              layer: int, own: NDArray[np.bool_]) -> None:
    """Draw the samples of a status and layer, at pixels (N, 2).

    The pointer shows place and thickness.
    """
    chosen = own & (profile.status == status)
    if not chosen.any():
        return
    samples = np.column_stack((uv, profile.arc_length * MM_PER_M, profile.thickness * MM_PER_M))
    x, y, *hover_data = pen_up(samples, chosen).T.astype(np.float32)
    figure.add('scatter', x=x, y=y, mode='lines', name=label(status), meta={'layer': layer},
               line={'color': STATUS_COLOURS[status], 'width': LINE_WIDTH_PX},
               customdata=np.stack(hover_data, axis=1),
               hovertemplate='at %{customdata[0]:.1f} mm: %{customdata[1]:.3f} mm')


def _add_side(figure: Figure, name: str, colour: str, uv: Array,
              measured: NDArray[np.bool_], layer: int) -> None:
    """Draw the side points of the measured samples of a layer, at pixels (N, 2)."""
    if not measured.any():
        return
    x, y = pen_up(uv, measured).T.astype(np.float32)
    figure.add('scatter', x=x, y=y, mode='lines', name=name, hoverinfo='skip',
               meta={'layer': layer}, line={'color': colour, 'width': LINE_WIDTH_PX})


def jpeg_uri(image: NDArray[np.uint8]) -> str:
    """Return an RGB image (H, W, 3) as a JPEG of full colour resolution in an address.

    It has at most MOST_IMAGE_BYTES, unless the lowest of JPEG_QUALITIES needs more.
    """
    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    for quality in JPEG_QUALITIES:
        _, encoded = cv2.imencode('.jpg', bgr, (
            cv2.IMWRITE_JPEG_QUALITY, quality,
            cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444))
        if len(encoded) <= MOST_IMAGE_BYTES:
            break
    return data_uri(encoded.tobytes(), 'jpeg')


def data_uri(data: bytes, kind: str) -> str:
    """Return an address that holds a picture; ``kind`` is a MIME subtype such as ``jpeg``."""
    return f'data:image/{kind};base64,{base64.b64encode(data).decode()}'
