"""What a print shall be: strokes in order, with the width wanted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import LARGEST_TARGET_M, LEAST_TARGET_M
from bpc_perception.core.geometry import transform

FARTHEST_M = 10.0  # from the origin; beyond that, another unit was meant


class DesignError(ValueError):
    """A design, or where it lies, is not what was expected; the message says what to do."""


@dataclass(frozen=True)
class DesignStroke:
    """An uninterrupted run of path in which ink is wanted, through N points.

    Attributes:
        points: (N, 3) nozzle tip in the design's frame [m]; neighbours differ.
        widths: (N - 1,) wanted from each point to the next [m]; NaN = not told.
        layer: its number; 0 = the lowest.
        tool: number of the head that lays it.
        line: number of the line in the file at which it begins; 0 = from no file.

    Raises:
        DesignError: a value is none of these.
    """

    points: Array
    widths: Array
    layer: int = 0
    tool: int = 0
    line: int = 0

    def __post_init__(self) -> None:
        for name, found in self._faults():
            if found:
                raise DesignError(f'line {self.line}: expected {name}, found others'
                                  '; correct the design')

    def _faults(self) -> list[tuple[str, bool]]:
        """Return what is expected, and whether it is not there: the first that is counts."""
        points, widths = self.points, self.widths
        if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2:
            return [('two points of three coordinates or more', True)]
        if widths.shape != (len(points) - 1,):
            return [('a width for each piece between points', True)]
        told = widths[~np.isnan(widths)]
        return [
            (f'coordinates within {FARTHEST_M:g} m', not (np.abs(points) <= FARTHEST_M).all()),
            ('points that differ from the one before', not np.diff(points, axis=0).any(1).all()),
            (f'widths from {1e3 * LEAST_TARGET_M:g} to {1e3 * LARGEST_TARGET_M:g} mm',
             not ((told >= LEAST_TARGET_M) & (told <= LARGEST_TARGET_M)).all()),
            ('numbers of layer, tool and line from 0', min(self.layer, self.tool, self.line) < 0)]

    @cached_property
    def arc_length(self) -> Array:
        """The way (N,) from the first point to each [m]."""
        steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        return np.concatenate(([0.0], np.cumsum(steps)))

    @property
    def length(self) -> float:
        """From its first to its last point, along it [m]."""
        return float(self.arc_length[-1])


@dataclass(frozen=True)
class Design:
    """Strokes in the order in which they are to be laid; between them the nozzle travels.

    Attributes:
        strokes: one or more.
        notes: what the file has and the strokes have not, each with its line and why.

    Raises:
        DesignError: there is no stroke.
    """

    strokes: tuple[DesignStroke, ...]
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.strokes:
            raise DesignError('expected a design with strokes, found none; lay ink somewhere')

    @property
    def layers(self) -> int:
        """How many layers there are."""
        return 1 + max(stroke.layer for stroke in self.strokes)

    @property
    def length(self) -> float:
        """Of all strokes together [m]."""
        return sum(stroke.length for stroke in self.strokes)

    @property
    def tells_widths(self) -> bool:
        """Whether a width is told anywhere."""
        return any(not np.isnan(stroke.widths).all() for stroke in self.strokes)

    def moved_by(self, T_target_source: Array) -> Design:
        """Return the design in another frame, by a rigid transform (4, 4)."""
        return replace(self, strokes=tuple(
            replace(stroke, points=transform(T_target_source, stroke.points))
            for stroke in self.strokes))
