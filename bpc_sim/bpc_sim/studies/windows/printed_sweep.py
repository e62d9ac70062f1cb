"""The sweep of an ink as it would be printed, and what is measured of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.window.sweep import Drive, SweepLine
from bpc_sim.studies.windows.ink_law import InkLaw

LEVELS = 5
RANGE = 2.0  # from the middle of a sweep to its ends, of flow and of speed
LINE_M = 0.036
END_M = 0.008  # of each end so much is not looked at
SAMPLES = 30


@dataclass(frozen=True)
class Setting:
    """One line that is printed.

    Attributes:
        command: flow [m^3/s] or pressure [Pa].
        speed: of the nozzle [m/s].
        flow: that comes out [m^3/s].
        factor: by which this line is wider than the law says.
        width: its true mean where it is looked at [m]; NaN = it breaks.
    """

    command: float
    speed: float
    flow: float
    factor: float
    width: float


def print_sweep(ink: InkLaw, rng: np.random.Generator) -> list[Setting]:
    """Return the lines of a sweep: LEVELS flows or pressures by as many speeds.

    Its middle is where somebody who tried the ink would put it: the strand is as fast as the
    nozzle, more or less.
    """
    middle = float(rng.uniform(6e-3, 12e-3))
    flow = np.pi * ink.radius**2 * middle * float(rng.uniform(0.7, 1.6))
    low, high = (ink.command(flow * share) for share in (1 / RANGE, RANGE))
    commands = np.geomspace(low, high, LEVELS) * float(rng.uniform(0.95, 1.05))
    s = np.linspace(END_M, LINE_M - END_M, SAMPLES)
    lines = []
    for speed in np.geomspace(middle / RANGE, middle * RANGE, LEVELS).tolist():
        for command in commands.tolist():
            flow, factor = ink.flow(command), float(np.exp(ink.scatter * rng.standard_normal()))
            width = (np.nan if ink.breaks(flow, speed)
                     else factor * float(ink.along(flow, speed, s).mean()))
            lines.append(Setting(command, speed, flow, factor, width))
    return lines


def measure_sweep(ink: InkLaw, printed: list[Setting],
                  rng: np.random.Generator) -> list[SweepLine]:
    """Return what is measured of lines, each with an error as large as its sigma says."""
    lines = []
    for number, line in enumerate(printed, 1):
        share = float(rng.uniform(0.005, 0.015))
        area_share = 3 * share
        lines.append(swept(
            ink, line, number, line.width * (1 + share * rng.standard_normal()),
            share * line.width,
            line.flow / line.speed * line.factor * (1 + area_share * rng.standard_normal()),
            area_share * line.flow / line.speed))
    return lines


def swept(ink: InkLaw, line: Setting, number: int, width: float, width_sigma: float,
          area: float = np.nan, area_sigma: float = np.nan) -> SweepLine:
    """Return a line with what was measured of it [m, m^2]; NaN = nothing."""
    known = np.isfinite(width)
    return SweepLine(
        f'line {number}', line.speed,
        flow=line.command if ink.drive == Drive.FLOW else np.nan,
        pressure=line.command if ink.drive == Drive.PRESSURE else np.nan,
        width=width, width_sigma=width_sigma,
        area=area if known else np.nan, area_sigma=area_sigma if known else np.nan)
