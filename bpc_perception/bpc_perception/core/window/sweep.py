"""The lines of a sweep: what each was printed with, and how it came out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
import math

import numpy as np

from bpc_perception.core.arrays import Array

LEVEL_SHARE = 0.02  # settings closer than this are one level
TEMPERATURE_LEVEL_K = 1.0


class WindowError(ValueError):
    """A window cannot be told; the message says what was expected, found, and what to do."""


class Drive(Enum):
    """What pushes the ink out, as an attribute of SweepLine."""

    FLOW = 'flow'
    PRESSURE = 'pressure'


@dataclass(frozen=True)
class SweepLine:
    """One line of a sweep; NaN = not known.

    Attributes:
        name: of the line, for people.
        speed: of the nozzle [m/s].
        flow: commanded [m^3/s].
        pressure: commanded [Pa].
        temperature: of the ink [K].
        width: mean of the line [m]; NaN = it broke up, is absent or was not seen.
        width_sigma: 1-sigma uncertainty of it [m].
        height: mean [m].
        height_sigma: 1-sigma uncertainty of it [m].
        area: mean of the cross-section [m^2].
        area_sigma: 1-sigma uncertainty of it [m^2].
        start_lag: from the command until ink comes out [s].
        stop_lag: from the command until none comes out [s].
    """

    name: str
    speed: float
    flow: float = math.nan
    pressure: float = math.nan
    temperature: float = math.nan
    width: float = math.nan
    width_sigma: float = math.nan
    height: float = math.nan
    height_sigma: float = math.nan
    area: float = math.nan
    area_sigma: float = math.nan
    start_lag: float = math.nan
    stop_lag: float = math.nan


def column(lines: Sequence[SweepLine], name: str) -> Array:
    """Return an attribute of each line (N,)."""
    return np.array([getattr(line, name) for line in lines], dtype=float)


def drive_of(lines: Sequence[SweepLine]) -> Drive:
    """Return what drives a sweep: the flow where all lines tell it, else the pressure.

    Raises WindowError if neither is told of all lines.
    """
    for drive in Drive:
        if lines and np.isfinite(column(lines, drive.value)).all():
            return drive
    without = [line.name for line in lines if not math.isfinite(line.flow)]
    raise WindowError('expected the flow of all lines, or the pressure of all lines, found '
                      f'neither, as in {without[0] if without else "a sweep without lines"}'
                      '; add them')


def levels(values: Array) -> list[float]:
    """Return which different settings there are among positive values (N,), in their order.

    A level is the geometric mean of values that follow each other within LEVEL_SHARE.
    """
    return [float(np.exp(group.mean())) for group in _groups(np.log(values), LEVEL_SHARE)]


def temperature_levels(values: Array) -> list[float]:
    """Return which different temperatures [K] there are among (N,); NaN are left out."""
    known = values[np.isfinite(values)]
    return [float(group.mean()) for group in _groups(known, TEMPERATURE_LEVEL_K)]


def _groups(values: Array, apart: float) -> list[Array]:
    """Return values (N,) in groups, between which they are further apart than that."""
    ordered = np.sort(values)
    groups = np.split(ordered, np.flatnonzero(np.diff(ordered) > apart) + 1)
    return [group for group in groups if len(group)]
