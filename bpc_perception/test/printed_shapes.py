"""Profiles of prints made from geometry: lines, and how wide the ink on them is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from perception_builders import START_NS

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile

MM = 1e-3
SPACING = 0.1 * MM
Distance = float | Callable[[Array], Array]  # over the distance from the stroke's start


@dataclass(frozen=True)
class Line:
    """A stroke through corners [mm], its ink reaching so far [mm] to the left and to the right."""

    corners: Sequence[tuple[float, float]]
    left: Distance = 0.5
    right: Distance = 0.5
    layer: int = 0
    # Status by stretch of the stroke [mm]; else MEASURED.
    statuses: dict[tuple[float, float], Status] = field(default_factory=dict)
    height: float = 0.4  # [mm]


def printed(lines: Sequence[Line], sigma: float = 0.01, layer_height: float = 0.35,
            turned: Array | None = None) -> ThicknessProfile:
    """A print of lines on a bed, 1-sigma of its widths [mm], turned by a matrix (3, 3)."""
    parts = [_samples(line) for line in lines]
    stroke = np.repeat(np.arange(1, len(lines) + 1), [len(part[0]) for part in parts])
    along, places, left, right, status = (np.concatenate(column) for column in zip(
        *parts, strict=True))
    layer = np.array([line.layer for line in lines])[stroke - 1]
    points = np.column_stack((places, layer * layer_height * MM))
    points = points if turned is None else points @ turned.T + (0.5, 0.1, 0.02)
    start = np.concatenate(([0.0], np.cumsum([part[0][-1] + 0.01 for part in parts])))[stroke - 1]
    arc, count = along + start, len(along)
    measured = np.where(status == Status.MEASURED, 1.0, np.nan)
    width = np.where(status == Status.GAP, 0.0, (left + right) * measured)
    height = np.array([line.height for line in lines])[stroke - 1] * MM
    unknown, no_points = np.full(count, np.nan), np.full((count, 3), np.nan)
    return ThicknessProfile(
        stamp_ns=START_NS, print_id='shapes', print_start_ns=START_NS, capture=0, method='',
        time=arc / 0.01, arc_length=arc, points=points, extruding=np.ones(count, bool),
        extruder_known=np.ones(count, bool), stroke=stroke, status=status, thickness=width,
        sigma=sigma * MM * measured, left=left * measured, right=right * measured,
        left_points=no_points, right_points=no_points, layer=layer, height=height * measured,
        height_sigma=unknown, area=unknown, area_sigma=unknown,
        seen_in=np.zeros(count, np.intp), commanded_area=unknown,
        cause=np.zeros(count, np.uint8), shift=np.full(3, np.nan), tip_height=np.nan,
        processing_time=0.0)


def _samples(line: Line) -> tuple[Array, Array, Array, Array, Array]:
    """Distance from the start (N,), places (N, 2), left and right (N,) [m], statuses (N,)."""
    corners = np.array(line.corners, float) * MM
    arcs = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))))
    along = np.linspace(0.0, arcs[-1], round(arcs[-1] / SPACING) + 1)
    places = np.stack([np.interp(along, arcs, axis) for axis in corners.T], axis=1)
    left, right = (np.broadcast_to(side(along / MM) if callable(side) else side, along.shape) * MM
                   for side in (line.left, line.right))
    status = np.full(len(along), Status.MEASURED, np.uint8)
    for (start, end), value in line.statuses.items():
        status[(along >= start * MM - 1e-9) & (along <= end * MM + 1e-9)] = value
    return along, places, left, right, status


def lattice(pitch_x: float = 4.0, pitch_y: float = 4.0, width: float = 1.0, count: int = 3,
            **others: object) -> list[Line]:
    """Strands along x, and across them in the layer above; pitches and width in mm."""
    half, reach_x, reach_y = width / 2, (count - 1) * pitch_x, (count - 1) * pitch_y
    along = [Line([(-1, pitch_y * row), (reach_x + 1, pitch_y * row)], half, half)
             for row in range(count)]
    across = [Line([(pitch_x * column, -1), (pitch_x * column, reach_y + 1)], half, half, 1,
                   **others) for column in range(count)]  # type: ignore[arg-type]
    return along + across
