"""At which settings lines have proven that ink can be printed: nothing is told beyond."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, KDTree, QhullError

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.window.sweep import column, Drive, SweepLine, WindowError

SLACK = 1e-6  # of the range; a setting of the border itself is proven


@dataclass(frozen=True, eq=False)
class Proven:
    """The settings between lines that came out well, and nearer to such than to one that failed.

    Attributes:
        drive: what pushes the ink out.
        good: lines with a width.
        failed: lines without.
    """

    drive: Drive
    good: tuple[SweepLine, ...]
    failed: tuple[SweepLine, ...]

    def __post_init__(self) -> None:
        try:
            ConvexHull(self._scaled(*self._settings(self.good)))
        except (QhullError, ValueError) as error:
            raise WindowError(
                f'expected lines at several values of both {self.drive.value} and speed, found '
                f'{len(self.good)} on one curve; print others beside it') from error

    @property
    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The least and the largest drive [m^3/s or Pa] and speed [m/s] of lines with a width."""
        drive, speed = self._settings(self.good)
        return ((float(drive.min()), float(drive.max())),
                (float(speed.min()), float(speed.max())))

    def holds(self, drive: Array, speed: Array) -> Flags:
        """Return which settings (N,) are proven [m^3/s or Pa, m/s]."""
        places = self._scaled(drive, speed)
        good = self._scaled(*self._settings(self.good))
        hull = ConvexHull(good).equations
        inside = (places @ hull[:, :2].T + hull[:, 2] <= SLACK).all(axis=1)
        if self.failed:
            bad = self._scaled(*self._settings(self.failed))
            # A line that failed where another came out well speaks against the setting.
            inside &= KDTree(good).query(places)[0] < KDTree(bad).query(places)[0] - SLACK
        return np.asarray(inside)

    def outline(self) -> tuple[Array, Array]:
        """Return the corners (K,) of the area between good lines [m^3/s or Pa, m/s]."""
        drive, speed = self._settings(self.good)
        corners = ConvexHull(self._scaled(drive, speed)).vertices
        closed = np.append(corners, corners[0])
        return drive[closed], speed[closed]

    def _settings(self, lines: Sequence[SweepLine]) -> tuple[Array, Array]:
        return column(lines, self.drive.value), column(lines, 'speed')

    def _scaled(self, drive: Array, speed: Array) -> Array:
        """Return settings (N, 2) as logarithms, from 0 to 1 over what was printed well."""
        return np.column_stack([
            np.log(values / low) / np.log(high / low)
            for values, (low, high) in zip((drive, speed), self.limits, strict=True)])
