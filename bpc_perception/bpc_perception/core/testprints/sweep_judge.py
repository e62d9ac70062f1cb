"""What a sweep of lines tells: a row for each line, the lag, and drift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.amounts import COMMON_SIGMA, LEAST_KNOWN, STEADY_M
from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.printability.uncertainty import OF_STROKE, sigma_of_mean
from bpc_perception.core.profile import Status
from bpc_perception.core.testprints.finding import Finding
from bpc_perception.core.testprints.lag import (
    Delay,
    Lag,
    lag_of,
    start_delay,
    STATE_PERIOD_S,
    stop_delay,
)
from bpc_perception.core.testprints.matching import MatchedPrint
from bpc_perception.core.testprints.plan import Part, StrokePlan

TORN = 0.05  # share of a line on which bed is seen, from which on it has no width of its own


@dataclass(frozen=True)
class LineResult:
    """A line of a sweep; NaN = not known.

    Attributes:
        line: number of its stroke, from 1.
        plan: how it was to be printed.
        width, height, area: means over its steady part [m, m, m^2].
        width_sigma, height_sigma, area_sigma: 1-sigma uncertainties of the means, with what is
            alike along the line.
        samples: of its width.
        start, stop: how late ink came and went.
        note: why there is no width; empty = there is.
    """

    line: int
    plan: StrokePlan
    width: float
    width_sigma: float
    height: float
    height_sigma: float
    area: float
    area_sigma: float
    samples: int
    start: Delay
    stop: Delay
    note: str


@dataclass(frozen=True)
class SweepResult:
    """What a sweep tells.

    Attributes:
        lines: in the order in which they were laid.
        start, stop: lag of the extruder.
        drift: of the width from the first to the last of the repeated lines.
    """

    lines: tuple[LineResult, ...]
    start: Lag
    stop: Lag
    drift: Finding

    @property
    def findings(self) -> list[Finding]:
        """What is told of the print as a whole."""
        found = []
        for name, lag in (('start_lag', self.start), ('stop_lag', self.stop)):
            found.append(Finding.of_print(name, lag.time, lag.sigma, 's', lag.lines, lag.note))
        return [*found, self.drift]


def judge_sweep(matched: MatchedPrint, period: float = STATE_PERIOD_S) -> SweepResult:
    """Return what a sweep of lines tells; ``period`` is that of the extruder's states [s]."""
    chosen = matched.test.numbers(Part.LINE, Part.REPEAT)
    results = tuple(_line(matched, index, period) for index in chosen)
    speeds = np.array([result.plan.speed for result in results])
    widths = np.array([result.width for result in results])
    width = float(np.nanmedian(widths)) if np.isfinite(widths).any() else np.nan
    return SweepResult(results, lag_of([result.start for result in results], speeds, width),
                       lag_of([result.stop for result in results], speeds, width),
                       _drift(results))


def _line(matched: MatchedPrint, index: int, period: float) -> LineResult:
    """Return what one line tells."""
    profile, middle = matched.profile, matched.judged(index)
    measured = middle & (profile.status == Status.MEASURED)
    step = float(np.median(np.diff(profile.arc_length)))
    note = _no_width(matched, index, middle, step)
    nan, length = np.nan, step * float(measured.sum())
    width = width_sigma = height = height_sigma = area = area_sigma = nan
    if not note:
        width = float(profile.thickness[measured].mean())
        width_sigma = sigma_of_mean(profile.sigma[measured], length, 1)
        high = measured & np.isfinite(profile.height)
        if high.sum() >= LEAST_KNOWN * measured.sum():
            height = float(profile.height[high].mean())
            height_sigma = sigma_of_mean(profile.height_sigma[high], length, 1)
        told = measured & np.isfinite(profile.area)
        if told.sum() >= LEAST_KNOWN * measured.sum():
            area, area_sigma = _mean_area(profile.area[told], profile.area_sigma[told], length)
    return LineResult(index + 1, matched.test.plans[index], width, width_sigma, height,
                      height_sigma, area, area_sigma, int(measured.sum()),
                      start_delay(matched, index, period), stop_delay(matched, index, period),
                      note)


def _mean_area(area: Array, sigma: Array, length: float) -> tuple[float, float]:
    """Return the mean of areas (K,) [m^2] along a length [m], and its uncertainty."""
    mean = float(area.mean())
    alike = np.sqrt(min(1.0, STEADY_M / length)) * float(np.mean(np.nan_to_num(sigma)))
    return mean, float(np.hypot(alike, COMMON_SIGMA * mean))


def _no_width(matched: MatchedPrint, index: int, middle: Flags, step: float) -> str:
    """Return why a line has no width; empty = it has one.

    Args:
        matched: the print.
        index: of the planned stroke.
        middle: (N,) samples of the part that is judged.
        step: between samples [m].
    """
    begin, end = matched.test.plans[index].judged
    planned = (end - begin) / step
    status = matched.profile.status[middle]
    measured, bare = (float((status == one).sum()) for one in (Status.MEASURED, Status.GAP))
    if not len(status):
        return 'it is not printed'
    if bare > TORN * (measured + bare):
        return f'the line is torn: {bare / (measured + bare):.0%} of it are bare'
    if measured < LEAST_KNOWN * planned:
        return f'{min(measured / planned, 1.0):.0%} of it are measured'
    return ''


def _drift(results: tuple[LineResult, ...]) -> Finding:
    """Return how much wider the last of the repeated lines is than the first [%].

    What is alike along the whole print cancels.
    """
    repeated = [result for result in results if result.plan.part == Part.REPEAT]
    name = 'drift_of_width'
    if len(repeated) < 2 or np.isnan((repeated[0].width, repeated[-1].width)).any():
        return Finding.of_print(name, np.nan, np.nan, '%', 0,
                                'the repeated line is not measured twice')
    first, last = repeated[0], repeated[-1]
    own = np.sqrt(OF_STROKE) * np.hypot(first.width_sigma, last.width_sigma)
    return Finding.of_print(name, 100 * (last.width / first.width - 1),
                            float(100 * own / first.width), '%', first.samples + last.samples)
