"""Strokes of a design as they come, piece by piece."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.design.design import Design, DesignError, DesignStroke
from bpc_perception.files.design.refusals import refusal

MM = 1e-3
MOST_POINTS = 2_000_000  # of a design
SAME_LEVEL_MM = 0.01
AXES = np.array(list('xyz'))
MOST_NOTES = 20


@dataclass
class _Run:
    """A stroke that is going on, in millimetres."""

    points: list[Array]
    placed: list[Flags]
    widths: list[float]
    lines: list[int]
    tool: int
    layer: int | None


class LaidInk:
    """The strokes that a file lays."""

    def __init__(self) -> None:
        self._runs: list[_Run] = []
        self._goes_on = False
        self._count = 0

    def stop(self) -> None:
        """End the stroke that goes on, if any."""
        self._goes_on = False

    def lay(self, points: Array, placed: Flags, line: int, tool: int, layer: int | None,
            width: float) -> None:
        """Lay ink along points (K, 3) from where the nozzle is [mm].

        Args:
            points: the first is where the nozzle is.
            placed: (K, 3) which coordinates are told by then.
            line: number of the line that says so.
            tool: that lays it.
            layer: number of the layer as the file counts; None = not told.
            width: wanted [m]; NaN = not told.

        Raises:
            DesignError: there are too many points.
        """
        self._count += len(points)
        if self._count > MOST_POINTS:
            raise refusal(line, f'a design of up to {MOST_POINTS} points', 'more',
                          'is it the right file?')
        last = self._runs[-1] if self._runs else None
        if last is None or not self._goes_on or (last.tool, last.layer) != (tool, layer):
            last = _Run([points[0]], [placed[0]], [], [], tool, layer)
            self._runs.append(last)
        for point, known in zip(points[1:], placed[1:], strict=True):
            if (point != last.points[-1]).any():
                last.points.append(point)
                last.placed.append(known)
                last.widths.append(width)
                last.lines.append(line)
        self._goes_on = True

    def design(self) -> Design:
        """Return the design. Raises DesignError where no ink is laid at a place that is known.

        A coordinate that the file never gives absolutely counts from where the file begins. Ink
        from a place that was not known yet is left out, with a note.
        """
        ever = np.any([np.zeros(3, bool), *(run.placed[-1] for run in self._runs)], axis=0)
        strokes: list[_Run] = []
        notes: list[str] = []
        for run in self._runs:
            known = ~(~np.array(run.placed) & ever).any(axis=1)
            first = int(np.argmax(known)) if known.any() else len(known)
            if first:
                where = ' and '.join(AXES[~run.placed[0] & ever])
                notes.append(f'line {run.lines[0]}: ink is left out up to where {where} is told')
            if len(known) - first > 1:
                strokes.append(_Run(run.points[first:], run.placed, run.widths[first:],
                                    run.lines[first:], run.tool, run.layer))
        if not strokes:
            found = notes[0] if notes else 'none'
            raise DesignError(f'expected moves that lay ink, found {found}'
                              '; give places absolutely, with G90, before ink is laid')
        if len(notes) > MOST_NOTES:
            notes[MOST_NOTES:] = [f'and {len(notes) - MOST_NOTES} more']
        layers = _layers(strokes)
        return Design(tuple(
            DesignStroke(MM * np.array(run.points), np.array(run.widths), layer, run.tool,
                         run.lines[0])
            for run, layer in zip(strokes, layers, strict=True)), tuple(notes))


def _layers(strokes: list[_Run]) -> list[int]:
    """Return the number of the layer of each stroke, from 0.

    As the file counts; what it lays before it counts is in the lowest. A file that does not count
    has a layer for each height at which strokes lie lowest.
    """
    counted = [run.layer for run in strokes]
    least = min((layer for layer in counted if layer is not None), default=None)
    if least is not None:
        return [0 if layer is None else layer - least for layer in counted]
    low = np.array([min(point[2] for point in run.points) for run in strokes])
    levels, place = np.unique(low, return_inverse=True)
    return list(np.cumsum(np.diff(levels, prepend=levels[0]) > SAME_LEVEL_MM)[place].tolist())
