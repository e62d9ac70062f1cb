"""From the lines of a sweep to the window of an ink."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np

from bpc_perception.core.testprints.lag import Delay, lag_of, STATE_PERIOD_S
from bpc_perception.core.window.contradictions import expect_agreement, Stranger, strangers
from bpc_perception.core.window.enough import expect_enough, LEAST_LINES
from bpc_perception.core.window.model import fit_model, Model, Prediction
from bpc_perception.core.window.proven import Proven
from bpc_perception.core.window.sweep import (
    column,
    Drive,
    drive_of,
    SweepLine,
    TEMPERATURE_LEVEL_K,
    temperature_levels,
    WindowError,
)
from bpc_perception.core.window.window import Grid, grid_of, recommend, speeds_of, Wanted
from bpc_perception.core.window.words import at, KELVIN, moved

SIZES = ('height', 'area')


@dataclass(frozen=True, eq=False)
class InkWindow:
    """What a sweep tells of an ink.

    Attributes:
        wanted: the target, with the temperature that was taken.
        lines: of the sweep.
        proven: settings that lines have proven, at that temperature.
        models: by what they tell: ``width``, and ``height`` and ``area`` where enough are known.
        grid: what is expected at many settings.
        drive: recommended flow [m^3/s] or pressure [Pa].
        speed: recommended [m/s].
        expected: by model, what is expected with the recommended setting.
        strangers: lines whose width does not fit to the others.
        start_lag: of the extruder [s]; NaN = not known.
        stop_lag: of the extruder [s]; NaN = not known.
    """

    wanted: Wanted
    lines: tuple[SweepLine, ...]
    proven: Proven
    models: dict[str, Model]
    grid: Grid
    drive: float
    speed: float
    expected: dict[str, Prediction]
    strangers: tuple[Stranger, ...]
    start_lag: float
    stop_lag: float

    @property
    def chance(self) -> float:
        """That a line with the recommended setting is within tolerance."""
        return float(self.expected['width'].chance(*self.wanted.band)[0])

    @property
    def delivered(self) -> tuple[float, float]:
        """Share of the commanded flow that comes out, and its uncertainty; NaN = not known."""
        if 'area' not in self.expected or self.proven.drive != Drive.FLOW:
            return math.nan, math.nan
        area = self.expected['area']
        share = float(area.value[0]) * self.speed / self.drive
        return share, share * float(area.mean_sigma[0])


def find_window(lines: Sequence[SweepLine], wanted: Wanted) -> InkWindow:
    """Return the window of an ink.

    Raises WindowError if the lines are too few, contradict each other, or never have the width.
    """
    drive = drive_of(lines)
    by_temperature, wanted, here = _at_temperature(lines, wanted)
    good = [line for line in lines if math.isfinite(line.width)]
    expect_enough(good, drive)
    proven = Proven(drive, tuple(line for line in here if math.isfinite(line.width)),
                    tuple(line for line in here if not math.isfinite(line.width)))
    _expect_speed(wanted, proven)
    width = fit_model(good, 'width', drive, by_temperature)
    expect_agreement(width)
    models = {'width': width}
    for of in SIZES:
        known = [line for line in good if math.isfinite(getattr(line, of))]
        if _are_enough(known, drive):
            models[of] = fit_model(known, of, drive, by_temperature)
    grid = grid_of(width, proven, wanted, speeds_of(proven))
    allowed = (grid if math.isnan(wanted.speed)
               else grid_of(width, proven, wanted, np.array((wanted.speed,))))
    best = recommend(width, proven, allowed, wanted)
    one = np.array(best[:1]), np.array(best[1:])
    return InkWindow(
        wanted, tuple(lines), proven, models, grid, *best,
        {of: model.predict(*one, wanted.temperature) for of, model in models.items()},
        tuple(strangers(width)), _lag(lines, 'start_lag'), _lag(lines, 'stop_lag'))


def _at_temperature(lines: Sequence[SweepLine],
                    wanted: Wanted) -> tuple[bool, Wanted, list[SweepLine]]:
    """Return whether the temperature counts, what is wanted with it, and the lines with it.

    Only a temperature that lines were printed with is taken: the one that is wanted, else that of
    most lines. Raises WindowError.
    """
    temperature = column(lines, 'temperature')
    found = temperature_levels(temperature)
    if not found:
        if math.isfinite(wanted.temperature):
            raise WindowError('expected lines that tell their temperature, found none; leave out '
                              '--temperature-c')
        return False, wanted, list(lines)
    if not np.isfinite(temperature).all():
        unknown = next(line.name for line in lines if math.isnan(line.temperature))
        raise WindowError('expected the temperature of all lines, or of none, found none of '
                          f'{unknown}; add it')
    of_line = [min(found, key=lambda level: abs(level - value)) for value in temperature.tolist()]
    taken = max(found, key=of_line.count)
    if math.isfinite(wanted.temperature):
        taken = min(found, key=lambda level: abs(level - wanted.temperature))
        if abs(taken - wanted.temperature) > TEMPERATURE_LEVEL_K:
            shown = ', '.join(f'{level - KELVIN:.3g}' for level in found)
            raise WindowError(f'expected a temperature that lines were printed with ({shown} °C), '
                              f'found {wanted.temperature - KELVIN:.3g} °C; choose one of these '
                              'with --temperature-c')
    return (len(found) > 1, Wanted(wanted.width, wanted.tolerance, wanted.speed, taken),
            [line for line, level in zip(lines, of_line, strict=True) if level == taken])


def _expect_speed(wanted: Wanted, proven: Proven) -> None:
    """Raise WindowError if the speed that is wanted is none that lines were printed with."""
    low, high = proven.limits[1]
    if not math.isnan(wanted.speed) and not low <= wanted.speed <= high:
        edge = min(proven.good, key=lambda line: abs(math.log(line.speed / wanted.speed)))
        there = at(proven.drive, getattr(edge, proven.drive.value), wanted.speed)
        raise WindowError(f'expected a speed between {moved(low)} and {moved(high)}, as the sweep '
                          f'has it, found {moved(wanted.speed)}; print {there} and others there')


def _are_enough(lines: Sequence[SweepLine], drive: Drive) -> bool:
    if len(lines) < LEAST_LINES:
        return False
    try:
        expect_enough(lines, drive)
    except WindowError:
        return False
    return True


def _lag(lines: Sequence[SweepLine], name: str) -> float:
    """Return the lag common to all lines [s], as a test print tells it: not that of one speed."""
    delays = [Delay(time, STATE_PERIOD_S) for time in column(lines, name).tolist()]
    return lag_of(delays, column(lines, 'speed'), math.nan).time
