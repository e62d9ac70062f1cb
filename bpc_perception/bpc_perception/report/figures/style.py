"""What the figures have in common: axes, lines, filled bands, shaded stretches."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.display.legend import as_shown, STATUS_COLOURS, TARGET_COLOUR
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.wording import label
from bpc_perception.report.figures.figure import Figure

# An axis from 0 to 1 over the whole height, for stretches that are shaded.
FULL_HEIGHT_AXIS: dict[str, Any] = {'overlaying': 'y', 'range': (0, 1), 'fixedrange': True,
                                    'visible': False}


def axis(title: str, **style: Any) -> dict[str, Any]:
    """Return an axis with a title."""
    return {'title': {'text': title}, **style}


def single(values: Array) -> NDArray[np.float32]:
    """Return values in single precision."""
    return values.astype(np.float32)


def reference_line(dash: str) -> dict[str, Any]:
    """Return the style of a line to compare with, such as the target or a quartile."""
    return {'color': TARGET_COLOUR, 'width': 1.5, 'dash': dash}


def band_outline(x: Array, low: Array, high: Array) -> dict[str, NDArray[np.float32]]:
    """Return the outline between low and high (N,), one closed piece for each run without NaN."""
    known = np.isfinite(low + high)
    outline = [np.empty((2, 0))]
    for run in np.split(np.arange(len(x)), np.flatnonzero(np.diff(known)) + 1):
        if known[run].any():
            back = run[::-1]
            outline += [np.stack((x[run], low[run])), np.stack((x[back], high[back])),
                        np.full((2, 1), np.nan)]
    return dict(zip('xy', single(np.concatenate(outline, axis=1)), strict=True))


def shade_statuses(figure: Figure, profile: ThicknessProfile) -> None:
    """Shade the stretches without a thickness by status, on FULL_HEIGHT_AXIS as ``yaxis2``."""
    profile = as_shown(profile)
    for status in Status:
        if status != Status.MEASURED and (profile.status == status).any():
            figure.add(
                'scatter', **_stretch_outlines(profile.extents(status) * MM_PER_M), yaxis='y2',
                mode='lines', fill='toself',
                fillcolor=STATUS_COLOURS[status], opacity=0.25, line={'width': 0},
                name=label(status), hoverinfo='skip')


def _stretch_outlines(extents: Array) -> dict[str, NDArray[np.float32]]:
    """Return the outlines of stretches (R, 2) of the x axis, from 0 to 1 along y."""
    start, end = extents.T
    nan = np.full(len(extents), np.nan)
    x = np.stack((start, start, end, end, nan), axis=1)
    y = np.broadcast_to((0.0, 1.0, 1.0, 0.0, np.nan), x.shape)
    return {'x': single(x.ravel()), 'y': single(y.ravel())}
