"""Ink as it lies on the surface: the truth, by geometry, against which measurements are held."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from bpc_perception.core.arrays import Array
from bpc_sim.ink.curves import Curve
from bpc_sim.ink.strands import strands

# Arc lengths of any shape [m] to widths of the same shape [m].
WidthProfile = Callable[[Array], Array]

# Strands overlap by this much, lest rounding leaves cracks between them [m].
SEAM = 1e-9


def constant_width(width: float) -> WidthProfile:
    """The same width [m] everywhere."""
    return lambda s: np.full(np.shape(s), width)


def linear_width(start: float, end: float, length: float) -> WidthProfile:
    """A width that changes linearly over ``length`` [m] from ``start`` to ``end`` [m]."""
    return lambda s: start + (end - start) * np.clip(s / length, 0.0, 1.0)


def knot_width(s: Array, width: Array) -> WidthProfile:
    """Widths (K,) [m] at arc lengths s (K,) [m], between them a smooth monotone curve."""
    spline = PchipInterpolator(s, width)
    low, high = float(s[0]), float(s[-1])
    return lambda s: np.asarray(spline(np.clip(s, low, high)))


def random_gaps(length: float, count: int, fraction: float,
                rng: np.random.Generator) -> Array:
    """Gaps (count, 2) [m] of ``fraction`` of the length each, starts uniform; they may overlap.

    As in the paper; a gap that starts near the end is cut there.
    """
    starts = np.sort(rng.uniform(0.0, length, count))
    return np.stack((starts, np.minimum(starts + fraction * length, length)), axis=1)


@dataclass(frozen=True)
class Location:
    """Where points lie relative to a deposit; arrays of the points' shape.

    Attributes:
        s: arc length of the nearest cross-section [m]; NaN far from all ink.
        offset: signed distance from the path, positive to the left [m].
        heading: angle of the path's tangent there [rad].
        margin: <= 0 on the ink; outside about the distance to it [m], infinite far away.
    """

    s: Array
    offset: Array
    heading: Array
    margin: Array


@dataclass(frozen=True, eq=False)
class Deposit:
    """Ink along a curve: the union of the cross segments p(s) +- n(s) w(s) / 2, flat ends.

    Its cross-section is a parabola; unlike a circular cap it has no vertical rim, so that a
    camera up to atan(1 / (4 height_ratio)) off the normal sees both of its edges.

    Attributes:
        curve: the nozzle's path, in the surface frame.
        profile: width over arc length where there is ink [m].
        gaps: (G, 2) arc-length intervals without ink [m]; they may overlap.
        laid: arc length up to which ink has been laid so far [m].
        height_ratio: height of the bead at its middle, as a fraction of its width.
    """

    curve: Curve
    profile: WidthProfile
    gaps: Array = field(default_factory=lambda: np.empty((0, 2)))
    laid: float = np.inf
    height_ratio: float = 0.3

    @cached_property
    def runs(self) -> Array:
        """Arc-length intervals (R, 2) that carry ink, in order [m]."""
        runs, position = [], 0.0
        stop = min(self.laid, self.curve.length)
        for start, end in (*sorted(self.gaps.tolist()), (stop, stop)):
            if min(start, stop) > position:
                runs.append((position, min(start, stop)))
            position = max(position, end)
        return np.array(runs).reshape(-1, 2)

    @cached_property
    def max_width(self) -> float:
        """The largest width of the profile [m], to the density of a thousand samples."""
        return float(self.profile(self.curve.uniform(1001)).max())

    @cached_property
    def area(self) -> float:
        """Area of the ink [m^2], as long as strands do not overlap.

        Where the path bends, what the outer half gains the inner half loses: the integral of
        the width over arc length is exact.
        """
        nodes, weights = np.polynomial.legendre.leggauss(200)
        return float(sum((end - start) / 2 * (
            weights @ self.profile(start + (nodes + 1) * (end - start) / 2))
            for start, end in self.runs))

    def inked(self, s: Array) -> NDArray[np.bool_]:
        """Whether the path carries ink at arc lengths s [m]."""
        return self.beyond_run(s) <= 0

    def width(self, s: Array) -> Array:
        """True width at arc lengths s (N,) [m]; 0 in gaps and where nothing is laid yet."""
        return np.where(self.inked(s), self.profile(s), 0.0)

    def sides(self, s: Array) -> tuple[Array, Array]:
        """True left and right side points, each (N, 2) [m], at arc lengths s (N,)."""
        points, half = self.curve.points(s), self.width(s)[:, None] / 2
        normals = self.curve.normals(s)
        return points + half * normals, points - half * normals

    def height(self, points: Array) -> Array:
        """Height (N,) of the bead above the surface at points (N, 2) [m]; 0 on the bed."""
        location = self.locate(points)
        width = self.profile(location.s)
        return np.where(location.margin <= 0,
                        self.height_ratio * width * (1 - (2 * location.offset / width)**2), 0.0)

    def covers(self, points: Array) -> NDArray[np.bool_]:
        """Whether points (N, 2) or (N, M, 2) [m] lie on ink."""
        return self.locate(points).margin <= 0

    def locate(self, points: Array) -> Location:
        """Find the cross-section on which, or nearest to which, points of the surface lie.

        Where strands are close, that with the smallest margin counts: coverage is the union.

        Args:
            points: (N, 2), or N groups (N, M, 2) of points within about a pixel of one
                another, for which one search serves; surface frame [m].
        """
        groups = points if points.ndim == 3 else points[:, None]
        shape = groups.shape[:2]
        s, offset, heading = (np.full(shape, np.nan) for _ in range(3))
        margin = np.full(shape, np.inf)
        centres = groups.mean(axis=1)
        reach = self.max_width / 2 + 1e-3
        for strand in strands(self.curve):
            if not len(self.runs) or strand.s[0] > self.runs[-1, 1] + reach:
                continue
            near = strand.near(centres, reach)
            if not len(near):
                continue
            found = strand.feet(groups[near])
            beyond = np.maximum(np.abs(found[1]) - self.profile(found[0]) / 2,
                                self.beyond_run(found[0]))
            better = ((found[0] >= strand.start - SEAM) & (found[0] <= strand.end + SEAM)
                      & (beyond < margin[near]))
            for values, new in zip((s, offset, heading, margin), (*found, beyond), strict=True):
                values[near] = np.where(better, new, values[near])
        return Location(*(values.reshape(points.shape[:-1])
                          for values in (s, offset, heading, margin)))

    def beyond_run(self, s: Array) -> Array:
        """Distance along the path from s to the ink, negative inside a run [m]."""
        if not len(self.runs):
            return np.full(np.shape(s), np.inf)
        borders = self.runs.ravel().copy()
        if self.curve.closed and borders[0] == 0 and borders[-1] == self.curve.length:
            borders[[0, -1]] = -np.inf, np.inf  # one run goes on in the other
        following = np.searchsorted(borders, s)
        padded = np.concatenate(([-np.inf], borders, [np.inf]))
        distance = np.minimum(s - padded[following], padded[following + 1] - s)
        return np.where(following % 2 == 1, -distance, distance)
