"""Where an ink meets its target, and which setting to take."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.window.model import Model
from bpc_perception.core.window.proven import Proven
from bpc_perception.core.window.sweep import column, WindowError
from bpc_perception.core.window.words import at, moved, several, wide

MET = 0.95  # chance of a line to be within tolerance, from which a setting is in the window
SPEEDS = 61
DRIVES = 241
SPEED_DIGITS, DRIVE_DIGITS = 3, 4  # as people set them


@dataclass(frozen=True)
class Wanted:
    """What is wanted.

    Attributes:
        width: of the bead [m].
        tolerance: how far a width may be off it, as a share.
        speed: of the nozzle [m/s]; NaN = the best.
        temperature: of the ink [K]; NaN = it does not count.
    """

    width: float
    tolerance: float
    speed: float = math.nan
    temperature: float = math.nan

    @property
    def band(self) -> tuple[float, float]:
        """The least and the largest width allowed [m]."""
        return self.width * (1 - self.tolerance), self.width * (1 + self.tolerance)


@dataclass(frozen=True, eq=False)
class Grid:
    """What is expected at many settings, V speeds by D drives.

    Attributes:
        speed: (V,) [m/s].
        drive: (D,) flows [m^3/s] or pressures [Pa].
        width: (V, D) expected [m].
        spread: (V, D) of a new line, as a share.
        chance: (V, D) that a line is within tolerance; NaN = not proven.
    """

    speed: Array
    drive: Array
    width: Array
    spread: Array
    chance: Array

    @property
    def proven(self) -> Flags:
        """Which settings (V, D) lines have proven."""
        return np.isfinite(self.chance)

    @property
    def met(self) -> Flags:
        """Which settings (V, D) are in the window."""
        return self.chance >= MET


def grid_of(model: Model, proven: Proven, wanted: Wanted, speed: Array) -> Grid:
    """Return what is expected at speeds (V,) [m/s] and all drives that were printed."""
    drive = np.geomspace(*proven.limits[0], DRIVES)
    every_speed, every_drive = (axis.ravel() for axis in np.meshgrid(speed, drive, indexing='ij'))
    found = model.predict(every_drive, every_speed, wanted.temperature)
    chance = np.where(proven.holds(every_drive, every_speed), found.chance(*wanted.band), np.nan)
    shape = len(speed), len(drive)
    return Grid(speed, drive, found.value.reshape(shape), found.spread.reshape(shape),
                chance.reshape(shape))


def speeds_of(proven: Proven) -> Array:
    """Return speeds (V,) over all that were printed [m/s]."""
    return rounded(np.geomspace(*proven.limits[1], SPEEDS), SPEED_DIGITS)


def rounded(values: Array, digits: int) -> Array:
    """Return values (N,) with so many digits."""
    return np.array([float(f'{value:.{digits}g}') for value in values.tolist()])


def on_target(grid: Grid, target: float) -> tuple[Array, Array]:
    """Return the settings (K,) whose expected width [m] is the target: drives and speeds."""
    above = np.log(grid.width / target)
    row, left = np.nonzero((above[:, :-1] <= 0) != (above[:, 1:] <= 0))
    share = above[row, left] / (above[row, left] - above[row, left + 1])
    step = math.log(grid.drive[1] / grid.drive[0])
    return rounded(grid.drive[left] * np.exp(share * step), DRIVE_DIGITS), grid.speed[row]


def recommend(model: Model, proven: Proven, grid: Grid, wanted: Wanted) -> tuple[float, float]:
    """Return the setting of a grid to take: drive [m^3/s or Pa] and speed [m/s].

    Of those whose expected width is the target it is the one at which a new line spreads least:
    far from the edges of the sweep, where most lines tell.

    Raises WindowError if there is none among what was printed.
    """
    drive, speed = on_target(grid, wanted.width)
    chosen = proven.holds(drive, speed)
    if not chosen.any():
        raise WindowError(_out_of_reach(model, proven, grid, wanted))
    drive, speed = drive[chosen], speed[chosen]
    best = int(np.argmin(model.predict(drive, speed, wanted.temperature).spread))
    return float(drive[best]), float(speed[best])


def _out_of_reach(model: Model, proven: Proven, grid: Grid, wanted: Wanted) -> str:
    """Return why a target is not met by what was printed, and what to print."""
    widths = np.where(grid.proven, grid.width, np.nan)
    where = '' if math.isnan(wanted.speed) else f' with {moved(wanted.speed)}'
    if not grid.proven.any():
        return (f'expected a speed at which lines came out well, found {where.strip()} none'
                '; print lines there, or choose another with --speed-mm-s')
    low, high = float(np.nanmin(widths)), float(np.nanmax(widths))
    nearest = min(model.lines, key=lambda line: abs(math.log(line.width / wanted.width)))
    there = at(model.drive, getattr(nearest, model.drive.value), nearest.speed)
    more = 'more' if wanted.width > high else 'less'
    if low <= wanted.width <= high:
        return (f'expected a width that was printed well, found {wide(wanted.width)} only near '
                f'lines that failed; nearest is {nearest.name} ({there}): print lines about it')
    failed = several(_failed_beyond(model, proven, wanted, low, high))
    proposed = (f'find out why {failed}, expected beyond, have no width, or print' if failed
                else 'print')
    return (f'expected a target between {wide(low)} and {wide(high)}, as the sweep has it{where}, '
            f'found {wide(wanted.width)}; nearest is {nearest.name} ({there}, '
            f'{wide(nearest.width)}): {proposed} lines with {more} {model.drive.value} per speed')


def _failed_beyond(model: Model, proven: Proven, wanted: Wanted, low: float,
                   high: float) -> list[str]:
    """Return which lines failed whose width would be beyond what was proven, as the target is.

    They need not be torn: a camera that is too far away does not see narrow ones.
    """
    if not proven.failed:
        return []
    drive, speed = (column(proven.failed, name) for name in (model.drive.value, 'speed'))
    width = model.predict(drive, speed, wanted.temperature).value
    beyond = width > high if wanted.width > high else width < low
    return [line.name for line, is_beyond in zip(proven.failed, beyond.tolist(), strict=True)
            if is_beyond]
