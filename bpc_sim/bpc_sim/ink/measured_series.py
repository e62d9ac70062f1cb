"""Unevenness from a published series: what was measured of lines while they were laid.

The files are those of github.com/leanfried/in-situ-monitoring-of-direct-ink-writing (MIT): a row
for each frame of a video, with its time and the places of the ink's surface; a cell is empty where
the surface was not found. The speed, in the names of their videos, is not in the files.
"""

from __future__ import annotations

from collections.abc import Sequence
import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bpc_perception.core.arrays import Array

TIME_COLUMN = 'time (s)'
REACH_COLUMN = 'up right Si dist (mm)'  # of the ink beneath the nozzle, from its rear edge
LEAST_VALUES = 100  # of a series that tells how uneven a line is


@dataclass(frozen=True, eq=False)
class MeasuredSeries:
    """Lines as they were measured, each with the mean 1.

    A path that is longer than a line goes on with the line backwards, and so on: that keeps the
    autocorrelation. Each layer takes the next line; the seed says where on it a layer begins.

    Attributes:
        lines: arc lengths (N,) from 0 on [m] and factors (N,) on the width, of each line.
    """

    lines: tuple[tuple[Array, Array], ...]

    def __post_init__(self) -> None:
        if not self.lines:
            raise ValueError('expected lines, found none; give one file at least')

    def factors(self, count: int, step: float, seed: int, layer: int) -> Array:
        """Return factors (count,) on the width, a step [m] apart."""
        place, factor = self.lines[layer % len(self.lines)]
        there_and_back = 2 * place[-1]
        begin = np.random.default_rng((seed, layer)).uniform(0, there_and_back)
        s = (begin + np.arange(count) * step) % there_and_back
        return np.interp(np.minimum(s, there_and_back - s), place, factor)


def read_series(files: Sequence[Path], speeds: Sequence[float],
                column: str = REACH_COLUMN) -> MeasuredSeries:
    """Read a file for each line, laid at these speeds [m/s].

    Raises:
        ValueError: a file is not such a table, or a speed is missing.
        OSError: a file cannot be read.
    """
    return MeasuredSeries(tuple(
        read_line(file, speed, column) for file, speed in zip(files, speeds, strict=True)))


def read_line(file: Path, speed: float, column: str = REACH_COLUMN) -> tuple[Array, Array]:
    """Return arc lengths (N,) from 0 on [m] and a column (N,) over its mean.

    The mean is that along the line; frames in which the column is empty are left out.

    Raises:
        ValueError: the file is not such a table.
        OSError: the file cannot be read.
    """
    with file.open(encoding='utf-8', newline='') as stream:
        reader = csv.DictReader(stream)
        missing = {TIME_COLUMN, column} - set(reader.fieldnames or ())
        if missing:
            raise ValueError(f'{file}: expected the columns {TIME_COLUMN} and {column}, found '
                             f'none named {" or ".join(sorted(missing))}; name another column')
        try:
            rows = np.array([(float(row[TIME_COLUMN]), float(row[column])) for row in reader
                             if row[column]]).reshape(-1, 2)
        except (TypeError, ValueError) as error:
            raise ValueError(f'{file}: expected numbers, found: {error}; correct them') from None
    time, value = rows[np.isfinite(rows).all(axis=1)].T
    if len(time) < LEAST_VALUES:
        raise ValueError(f'{file}: expected {LEAST_VALUES} values of {column} at least, found '
                         f'{len(time)}; name another column')
    if (np.diff(time) <= 0).any():
        raise ValueError(f'{file}: expected growing times, found others; sort the rows')
    s = (time - time[0]) * speed
    mean = np.trapezoid(value, s) / s[-1]
    if not mean > 0:
        raise ValueError(f'{file}: expected a mean above 0, found {mean:g} in {column}; name '
                         'another column')
    return s, value / mean
