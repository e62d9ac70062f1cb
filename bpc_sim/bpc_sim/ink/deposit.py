"""Ink as it lies on the surface: the geometric truth that measurements are compared with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from bpc_perception.core.arrays import Array
from bpc_sim.ink.curve_pieces import curve_pieces
from bpc_sim.ink.curves import Curve

# From arc lengths of any shape [m] to widths of the same shape [m]; also to heights of feet.
WidthProfile = Callable[[Array], Array]

SEARCH_MARGIN_M = 1e-3  # beyond the widest bead, within which points are located


def constant_width(width: float) -> WidthProfile:
    """Return a profile of the same width [m] everywhere."""
    return lambda s: np.full(np.shape(s), width)


ON_BED = constant_width(0.0)


def linear_width(start: float, end: float, length: float) -> WidthProfile:
    """Return a profile that changes linearly over ``length`` from ``start`` to ``end`` [m]."""
    return lambda s: start + (end - start) * np.clip(s / length, 0.0, 1.0)


def knot_width(s: Array, width: Array) -> WidthProfile:
    """Return a profile through widths (K,) [m] at arc lengths s (K,) [m], smooth and monotone."""
    spline = PchipInterpolator(s, width)
    low, high = float(s[0]), float(s[-1])
    return lambda s: np.asarray(spline(np.clip(s, low, high)))


def random_gaps(length: float, count: int, fraction: float,
                rng: np.random.Generator) -> Array:
    """Return gaps (count, 2) [m] at random places, as in the paper.

    Each has ``fraction`` of the length; a gap that starts near the end is cut there. Starts are
    uniformly distributed, so gaps may overlap.
    """
    starts = np.sort(rng.uniform(0.0, length, count))
    return np.stack((starts, np.minimum(starts + fraction * length, length)), axis=1)


@dataclass(frozen=True)
class Location:
    """Where points lie relative to a deposit; arrays in the shape of the points.

    Attributes:
        s: arc length of the nearest cross-section [m]; NaN far from all ink.
        offset: signed distance from the path, positive to the left [m].
        heading: angle of the path's tangent there [rad].
        margin: not positive on the ink; outside about the distance to it [m], infinite far away.
    """

    s: Array
    offset: Array
    heading: Array
    margin: Array


@dataclass(frozen=True, eq=False)
class Deposit:
    """Ink along a curve: the union of the cross segments p(s) +- n(s) w(s) / 2, with flat ends.

    Its cross-section is a parabola. Unlike a circular cap, a parabola has no vertical rim: a
    camera up to atan(1 / (4 height_ratio)) off the normal sees both edges.

    Attributes:
        curve: the nozzle's path, in the surface frame.
        profile: width over arc length, where there is ink [m].
        gaps: (G, 2) intervals of arc length without ink [m]; they may overlap.
        laid: arc length up to which ink has been laid [m].
        height_ratio: height of the bead at its middle above its foot, as a fraction of its width.
        base: height of the bead's foot above the bed, over arc length: what it lies on, or hangs
            over [m].
    """

    curve: Curve
    profile: WidthProfile
    gaps: Array = field(default_factory=lambda: np.empty((0, 2)))
    laid: float = np.inf
    height_ratio: float = 0.3
    base: WidthProfile = ON_BED

    @cached_property
    def runs(self) -> Array:
        """Intervals (R, 2) of arc length that carry ink, in order [m]."""
        runs, position = [], 0.0
        stop = min(self.laid, self.curve.length)
        for start, end in (*sorted(self.gaps.tolist()), (stop, stop)):
            if min(start, stop) > position:
                runs.append((position, min(start, stop)))
            position = max(position, end)
        return np.array(runs).reshape(-1, 2)

    @cached_property
    def max_width(self) -> float:
        """Largest width of the profile [m], as found in a thousand samples."""
        return float(self.profile(self.curve.uniform(1001)).max())

    @cached_property
    def level(self) -> float:
        """Mean height of the bead's foot above the bed [m]."""
        return float(np.mean([self.base(np.linspace(start, end, 101)).mean()
                              for start, end in self.runs] or 0.0))

    @cached_property
    def area(self) -> float:
        """Area of the ink [m^2], if strands do not overlap.

        Where the path bends, the outer half gains what the inner half loses: the integral of the
        width over arc length is exact.
        """
        nodes, weights = np.polynomial.legendre.leggauss(200)
        return float(sum((end - start) / 2 * (
            weights @ self.profile(start + (nodes + 1) * (end - start) / 2))
            for start, end in self.runs))

    def inked(self, s: Array) -> NDArray[np.bool_]:
        """Tell whether the path carries ink at arc lengths s [m], of any shape."""
        return self.beyond_run(s) <= 0

    def width(self, s: Array) -> Array:
        """Return the true width (N,) at arc lengths s (N,) [m]; 0 in gaps and not yet laid ink."""
        return np.where(self.inked(s), self.profile(s), 0.0)

    def sides(self, s: Array) -> tuple[Array, Array]:
        """Return the true left and right side points, (N, 2) each, at arc lengths s (N,) [m]."""
        points, half = self.curve.points(s), self.width(s)[:, None] / 2
        normals = self.curve.normals(s)
        return points + half * normals, points - half * normals

    def height(self, points: Array) -> Array:
        """Return the height (N,) of the bead above the bed at points (N, 2) [m]; 0 without ink."""
        location = self.locate(points)
        width = self.profile(location.s)
        return np.where(location.margin <= 0, self.base(location.s)
                        + self.height_ratio * width * (1 - (2 * location.offset / width)**2), 0.0)

    def within(self, start: float, end: float) -> Deposit:
        """Return the part of the ink between two arc lengths [m]."""
        outside = np.array(((0.0, start), (end, self.curve.length)))
        return replace(self, gaps=np.concatenate((self.gaps, outside)))

    def covers(self, points: Array) -> NDArray[np.bool_]:
        """Tell whether points (N, 2) or (N, M, 2) [m] lie on ink."""
        return self.locate(points).margin <= 0

    def locate(self, points: Array) -> Location:
        """Find the cross-section that points of the surface lie on, or the nearest one.

        Where strands are close, the one with the smallest margin counts: coverage is the union.

        Args:
            points: (N, 2) in the surface frame [m]; or (N, M, 2), N groups of points within
                about a pixel of each other, so that one search serves a group.
        """
        groups = points if points.ndim == 3 else points[:, None]
        shape = groups.shape[:2]
        s, offset, heading = (np.full(shape, np.nan) for _ in range(3))
        margin = np.full(shape, np.inf)
        centres = groups.mean(axis=1)
        reach = self.max_width / 2 + SEARCH_MARGIN_M
        for piece in curve_pieces(self.curve):
            if (not len(self.runs) or piece.s[0] > self.runs[-1, 1] + reach
                    or piece.s[-1] < self.runs[0, 0] - reach):
                continue
            near = piece.near(centres, reach)
            if not len(near):
                continue
            feet = piece.feet(groups[near])
            beyond = np.maximum(np.abs(feet.offset) - self.profile(feet.s) / 2,
                                self.beyond_run(feet.s))
            better = piece.spans(feet.s) & (beyond < margin[near])
            for values, new in ((s, feet.s), (offset, feet.offset), (heading, feet.heading),
                                (margin, beyond)):
                values[near] = np.where(better, new, values[near])
        return Location(*(values.reshape(points.shape[:-1])
                          for values in (s, offset, heading, margin)))

    def beyond_run(self, s: Array) -> Array:
        """Return the distance along the path from s to the ink [m], negative inside a run."""
        if not len(self.runs):
            return np.full(np.shape(s), np.inf)
        borders = self.runs.ravel().copy()
        if self.curve.closed and borders[0] == 0 and borders[-1] == self.curve.length:
            borders[[0, -1]] = -np.inf, np.inf  # the last run continues in the first
        following = np.searchsorted(borders, s)
        padded = np.concatenate(([-np.inf], borders, [np.inf]))
        distance = np.minimum(s - padded[following], padded[following + 1] - s)
        return np.where(following % 2 == 1, -distance, distance)
