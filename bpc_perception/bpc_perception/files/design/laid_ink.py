"""Strokes of a design as they come, piece by piece."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.design.design import Design, DesignError, DesignStroke
from bpc_perception.files.design.refusals import refusal

MM = 1e-3
MOST_POINTS = 2_000_000  # of a design
SAME_LEVEL_MM = 0.01
MOST_NOTES = 20
Point = tuple[float, float, float]  # [mm]
Known = tuple[bool, bool, bool]  # whether each coordinate is told


@dataclass
class _Run:
    """A stroke that is going on."""

    points: list[Point]
    placed: list[Known]
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

    def lay(self, way: list[Point], placed: Known, known: Known, line: int, tool: int,
            layer: int | None, width: float) -> None:
        """Lay ink along a way.

        Args:
            way: from where the nozzle is to where it goes.
            placed: which coordinates were told before.
            known: which are told now.
            line: number of the line that says so.
            tool: that lays it.
            layer: number of the layer as the file counts; None = not told.
            width: wanted [m]; NaN = not told.

        Raises:
            DesignError: there are too many points.
        """
        self._count += len(way)
        if self._count > MOST_POINTS:
            raise refusal(line, f'a design of up to {MOST_POINTS} points', 'more',
                          'is it the right file?')
        if not (self._goes_on and (self._runs[-1].tool, self._runs[-1].layer) == (tool, layer)):
            self._runs.append(_Run([way[0]], [placed], [], [], tool, layer))
        run = self._runs[-1]
        for number, point in enumerate(way[1:], 1):
            told = known if number == len(way) - 1 else placed
            if point != run.points[-1] or told != run.placed[-1]:
                run.points.append(point)
                run.placed.append(told)
                run.widths.append(width)
                run.lines.append(line)
        self._goes_on = bool(run.widths)
        if not run.widths:
            self._runs.pop()

    def design(self) -> Design:
        """Return the design. Raises DesignError where no ink is laid at a place that is known.

        A coordinate that the file never gives absolutely counts from where the file begins. Ink
        from a place that was not known yet is left out, with a note.
        """
        ever = [any(run.placed[-1][axis] for run in self._runs) for axis in range(3)]
        strokes: list[_Run] = []
        notes: list[str] = []
        for run in self._runs:
            first = next((number for number, told in enumerate(run.placed)
                          if not _missing(told, ever)), len(run.points))
            if first:
                where = ' and '.join(_missing(run.placed[0], ever))
                notes.append(f'line {run.lines[0]}: ink is left out up to where {where} is told')
            if len(run.points) - first > 1:
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


def _missing(told: Known, ever: list[bool]) -> list[str]:
    """Return the axes of which no coordinate is told yet, though there will be."""
    return [name for name, known, later in zip('xyz', told, ever, strict=True)
            if later and not known]


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
