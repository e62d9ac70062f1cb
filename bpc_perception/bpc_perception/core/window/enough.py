"""Whether a sweep has lines enough, and which to print next if not."""

from __future__ import annotations

from collections.abc import Sequence
import math

import numpy as np

from bpc_perception.core.window.sweep import column, Drive, levels, SweepLine, WindowError
from bpc_perception.core.window.words import at, driven, moved, several

LEAST_LEVELS = 3  # of drive and of speed: with two a bend is not seen
LEAST_LINES = 8  # three coefficients and the spread
STEP = 1.5  # from a level to one that is proposed


def expect_enough(lines: Sequence[SweepLine], drive: Drive) -> None:
    """Raise WindowError, which names the lines to print, unless a model can be fitted.

    Args:
        lines: those of a sweep of which the width is known.
        drive: what pushes the ink out.
    """
    if len(lines) < 2:
        raise WindowError(f'expected {LEAST_LINES} lines or more with a width, found '
                          f'{len(lines)}; print a sweep of {LEAST_LEVELS} × {LEAST_LEVELS}')
    pushed = levels(column(lines, drive.value))
    speeds = levels(column(lines, 'speed'))
    missing = _missing(lines, drive, pushed, speeds)
    proposed = f'print {several(at(drive, *each) for each in missing)}'
    for found, what, shown in ((pushed, drive.value, lambda value: driven(drive, value)),
                               (speeds, 'speed', moved)):
        if len(found) < LEAST_LEVELS:
            raise WindowError(
                f'expected lines with a width at {LEAST_LEVELS} different values of {what} or '
                f'more, found {len(found)} ({", ".join(map(shown, found))}); {proposed}')
    if len(lines) < LEAST_LINES:
        raise WindowError(f'expected {LEAST_LINES} lines or more with a width, found '
                          f'{len(lines)}; {proposed}')
    logs = np.log(np.column_stack((column(lines, drive.value), column(lines, 'speed'))))
    if abs(np.corrcoef(logs.T)[0, 1]) > 0.95:  # a variance inflation factor of 10
        raise WindowError(f'expected lines at each {drive.value} with several speeds, found that '
                          f'{drive.value} and speed vary together; {proposed}')


def _missing(lines: Sequence[SweepLine], drive: Drive, pushed: list[float],
             speeds: list[float]) -> list[tuple[float, float]]:
    """Return the settings of the least grid about lines at which there is none."""
    there = {(_near(pushed, getattr(line, drive.value)), _near(speeds, line.speed))
             for line in lines}
    rows, columns = _spread(pushed), _spread(speeds)
    grid = [(row, rate) for row in rows for rate in columns]
    return [(row, rate) for row, rate in grid
            if (_near(pushed, row), _near(speeds, rate)) not in there
            or row not in pushed or rate not in speeds] or grid


def _spread(found: list[float]) -> list[float]:
    """Return LEAST_LEVELS levels: of those that are there, and others about and between them."""
    if len(found) == 1:
        return [found[0] / STEP, found[0], found[0] * STEP]
    if len(found) == 2:
        return [found[0], math.sqrt(found[0] * found[1]), found[1]]
    return [found[0], found[len(found) // 2], found[-1]]


def _near(found: list[float], value: float) -> float:
    return min(found, key=lambda level: abs(math.log(level / value)))
