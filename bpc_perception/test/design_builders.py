"""Small designs, and paths and profiles of their prints, whose truth is geometry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from perception_builders import path_through, profile_of, START_NS

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.design.design import Design, DesignStroke
from bpc_perception.core.geometry import transform
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile

MM = 1e-3
SPACING = 0.2 * MM
LIFT = 2 * MM  # of the nozzle while it travels


def stroke_of(points: Sequence[Sequence[float]], layer: int = 0,
              width: float = np.nan) -> DesignStroke:
    """A stroke through points [mm] of a width [mm]."""
    return DesignStroke(np.array(points, float) * MM, np.full(len(points) - 1, width * MM), layer)


def lattice(lines: int = 10, size: float = 20.0, layers: int = 1) -> Design:
    """Parallel lines along x, then along y, each layer [mm]. Alike when turned by 90 degrees."""
    strokes = []
    places = np.linspace(0, size, lines)
    for layer in range(layers):
        z = 0.2 * (layer + 1)
        strokes += [stroke_of(((0, y, z), (size, y, z)), layer) for y in places]
        strokes += [stroke_of(((x, 0, z), (x, size, z)), layer) for x in places]
    return Design(tuple(strokes))


def snake() -> Design:
    """One stroke that turns back and forth, and a second one, an L, beside it."""
    there = [(x, y + 3 * row, 0.3) for row in range(6) for x, y in (
        ((0, 0), (25, 0)) if row % 2 == 0 else ((25, 0), (0, 0)))]
    return Design((stroke_of(there), stroke_of(((30, 0, 0.3), (30, 12, 0.3), (36, 12, 0.3)))))


def along(points: Array, length: float) -> Array:
    """Points on a line (N, 3), evenly spaced up to a length along it [m]."""
    arc = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    asked = np.linspace(0, min(length, arc[-1]), 1 + max(round(min(length, arc[-1]) / SPACING), 1))
    return np.stack([np.interp(asked, arc, column) for column in points.T], axis=1)


def printed(design: Design, T_base_design: Array | None = None, until: float = np.inf,
            left_out: Sequence[int] = ()) -> tuple[Array, Index]:
    """Where the nozzle went (N, 3), and which stroke (N,) it laid; 0 = travel, lifted.

    Args:
        design: that is printed.
        T_base_design: where it lies.
        until: length of ink after which the print stops [m].
        left_out: strokes of the design that are not printed.
    """
    points: list[Array] = []
    stroke: list[int] = []
    for number, wanted in enumerate(design.strokes):
        if number in left_out or until <= 1e-6:
            continue
        part = along(wanted.points, until)
        until -= wanted.length
        if points:
            way = np.array((points[-1][-1], points[-1][-1], part[0], part[0]))
            way[1:3, 2] += LIFT
            points.append(along(way, np.inf)[1:-1])
            stroke += [0] * len(points[-1])
        points.append(part)
        stroke += [max([0, *stroke]) + 1] * len(part)
    return (transform(np.eye(4) if T_base_design is None else T_base_design,
                      np.concatenate(points)), np.array(stroke))


def path_of(points: Array, stroke: Index, finished: bool = True) -> DepositionPath:
    """The path of a nozzle that went through points (N, 3) and laid strokes (N,)."""
    return path_through(points, extruding=stroke > 0, finished=finished)


def profile_along(points: Array, stroke: Index, left: Array | float = 0.0,
                  width: float = 1 * MM) -> ThicknessProfile:
    """A profile of a bead of this width, so far to the left of the nozzle (N,) [m]."""
    count = len(points)
    step = np.gradient(points, axis=0)
    side = np.stack((-step[:, 1], step[:, 0], np.zeros(count)), axis=1)
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-12)
    offset = np.broadcast_to(left, count)
    # Side points lie on the bed, below the nozzle.
    ground = points * (1, 1, 0)
    path = path_through(points)
    return replace(
        profile_of([width] * count), time=path.time, arc_length=path.arc_length, points=points,
        stroke=stroke, extruding=stroke > 0, print_start_ns=START_NS,
        status=np.where(stroke > 0, Status.MEASURED, Status.BARE).astype(np.uint8),
        left=width / 2 + offset, right=width / 2 - offset,
        left_points=ground + side * (offset + width / 2)[:, None],
        right_points=ground + side * (offset - width / 2)[:, None])
