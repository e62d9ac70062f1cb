"""A figure of plotly.js, the script that draws it in the browser."""

from __future__ import annotations

import base64
from importlib.resources import files
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

LEGEND_Y = -0.2  # below the axis and its title


class Figure:
    """Traces and layout as plotly.js takes them.

    They are not made by plotly's own classes: to load these and to let them check each property
    takes longer than all else on a page. Instead, the tests let them check.

    Attributes:
        traces: what is drawn, with its kind under ``type``.
        layout: axes, legend, shapes and images.
    """

    def __init__(self, legend_y: float = LEGEND_Y) -> None:
        """Make an empty figure with the layout that all share."""
        self.traces: list[dict[str, Any]] = []
        self.layout: dict[str, Any] = {
            'template': json.loads(packaged('templates/plotly_white.json')), 'autosize': True,
            'showlegend': True, 'hovermode': 'closest',
            'font': {'family': 'system-ui, sans-serif', 'size': 13},
            'margin': {'l': 55, 'r': 10, 't': 40, 'b': 50},
            'legend': {'orientation': 'h', 'yanchor': 'top', 'y': legend_y, 'x': 0,
                       'itemsizing': 'constant'}}

    def add(self, kind: str, **trace: Any) -> None:
        """Draw a trace of a kind, such as ``scatter``."""
        self.traces.append({'type': kind, **trace})

    def add_shape(self, kind: str, **shape: Any) -> None:
        """Draw a shape of a kind, such as ``rect``."""
        self.layout.setdefault('shapes', []).append({'type': kind, **shape})

    def lay_out(self, **layout: Any) -> Figure:
        """Replace parts of the layout; return the figure."""
        self.layout |= layout
        return self


def packaged(name: str) -> str:
    """Return a file of those that plotly brings for the browser."""
    return (files('plotly') / 'package_data' / name).read_text('utf-8')


def typed_array(values: NDArray[Any]) -> object:
    """Return an array as plotly.js reads it from JSON, which is smaller than a list of numbers.

    [plotly.js, typed arrays: dtype, bdata in base64, and shape if there is more than one axis]
    """
    if not values.size:
        return []
    shape = {'shape': ', '.join(map(str, values.shape))} if values.ndim > 1 else {}
    return {'dtype': values.dtype.str[1:], **shape,
            'bdata': base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()}
