"""Planar curves parametrised by exact arc length: the paths of the simulated prints.

All curves lie in the surface frame: x and y in the surface, z its normal towards the viewer, the
origin at the curve's centre.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import hyp2f1

from bpc_perception.core.arrays import Array

# From arc lengths (N,) [m] to points (N, 2) [m] and unit tangents (N, 2).
Locus = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Curve:
    """A planar curve parametrised by its arc length s in [0, length] [m].

    Attributes:
        length: arc length of the whole curve [m].
        locus: points and unit tangents at given arc lengths.
        breaks: inner arc lengths at which the curvature jumps, or at a corner the tangent [m].
        closed: whether the end meets the start.
    """

    length: float
    locus: Locus
    breaks: tuple[float, ...] = ()
    closed: bool = False

    def points(self, s: Array) -> Array:
        """Return points (N, 2) [m] at arc lengths s (N,) [m]."""
        return self.locus(s)[0]

    def tangents(self, s: Array) -> Array:
        """Return unit tangents (N, 2) in the direction of travel, at arc lengths s (N,) [m]."""
        return self.locus(s)[1]

    def normals(self, s: Array) -> Array:
        """Return unit normals (N, 2) to the left of travel, as seen with the surface in front."""
        tangents = self.tangents(s)
        return np.stack((-tangents[:, 1], tangents[:, 0]), axis=1)

    def uniform(self, count: int) -> Array:
        """Return arc lengths (count,) of evenly spaced samples, both ends included [m]."""
        return np.linspace(0.0, self.length, count)


def line(length: float) -> Curve:
    """Return a straight line along x of a length [m]."""
    def locus(s: Array) -> tuple[Array, Array]:
        points = np.stack((s - length / 2, np.zeros_like(s)), axis=1)
        return points, np.tile((1.0, 0.0), (len(s), 1))

    return Curve(length, locus)


def ring(radius: float, sweep: float = 2 * np.pi) -> Curve:
    """Return a circle of a radius [m], or its first ``sweep`` radians.

    It runs counter-clockwise from (radius, 0).
    """
    def locus(s: Array) -> tuple[Array, Array]:
        cos, sin = np.cos(s / radius), np.sin(s / radius)
        return radius * np.stack((cos, sin), axis=1), np.stack((-sin, cos), axis=1)

    return Curve(radius * sweep, locus, closed=bool(np.isclose(sweep, 2 * np.pi)))


def meander(pitch: float, length: float, strands: int) -> Curve:
    """Return straight strands along x, ``pitch`` apart, joined by half circles; all in [m]."""
    radius = pitch / 2
    period = length + np.pi * radius

    def locus(s: Array) -> tuple[Array, Array]:
        strand = np.clip(np.floor(s / period), 0, strands - 1)
        along = s - strand * period
        direction = np.where(strand % 2 == 0, 1.0, -1.0)
        angle = np.maximum(along - length, 0.0) / radius
        straight = np.minimum(along, length) - length / 2
        x = straight + radius * np.sin(angle)
        y = (strand - (strands - 1) / 2) * pitch + radius * (1 - np.cos(angle))
        return (np.stack((direction * x, y), axis=1),
                np.stack((direction * np.cos(angle), np.sin(angle)), axis=1))

    starts = period * np.arange(1, strands)
    breaks = np.sort(np.concatenate((starts, starts - np.pi * radius)))
    return Curve(period * strands - np.pi * radius, locus, tuple(breaks.tolist()))


def turtle(moves: Sequence[tuple[float, float]], start: tuple[float, float] = (0.0, 0.0),
           heading: float = 0.0, closed: bool = False) -> Curve:
    """Return straight lines, arcs and corners, one after the other.

    Args:
        moves: length [m] and turn [rad, positive to the left] of each; a line has no turn, and
            a corner no length.
        start: start point [m].
        heading: angle of the first tangent [rad].
        closed: whether the curve ends where it started.
    """
    lengths, turns = np.array(moves, float).T
    directions = heading + np.concatenate(([0.0], np.cumsum(turns)))[:-1]
    legs = np.flatnonzero(lengths > 0)
    lengths, turns, directions = lengths[legs], turns[legs], directions[legs]
    starts = np.concatenate(([0.0], np.cumsum(lengths)))

    def advance(leg: NDArray[np.intp], along: Array) -> Array:
        # The chord of an arc is its length times sinc of half its turn.
        turned = turns[leg] * along / lengths[leg]
        chord = along * np.sinc(turned / (2 * np.pi))
        angle = directions[leg] + turned / 2
        return chord[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=1)

    every = np.arange(len(legs))
    corners = np.array(start) + np.concatenate(
        (np.zeros((1, 2)), np.cumsum(advance(every, lengths), axis=0)))

    def locus(s: Array) -> tuple[Array, Array]:
        leg = np.clip(np.searchsorted(starts, s, side='right') - 1, 0, len(legs) - 1)
        along = s - starts[leg]
        angle = directions[leg] + turns[leg] * along / lengths[leg]
        return (corners[leg] + advance(leg, along),
                np.stack((np.cos(angle), np.sin(angle)), axis=1))

    return Curve(float(starts[-1]), locus, tuple(starts[1:-1].tolist()), closed)


def polyline(points: Array) -> Curve:
    """Return straight lines through points (N, 2) [m]."""
    legs = np.diff(points, axis=0)
    angles = np.unwrap(np.arctan2(legs[:, 1], legs[:, 0]))
    moves = []
    for length, turn in zip(np.linalg.norm(legs, axis=1).tolist(),
                            np.append(np.diff(angles), 0.0).tolist(), strict=True):
        moves += [(length, 0.0), (0.0, turn)]
    x, y = points[0].tolist()
    return turtle(moves[:-1], (x, y), float(angles[0]))


def archimedean(a: float, phi_start: float, phi_end: float) -> Curve:
    """Return the spiral r = a phi for 0 <= phi_start <= phi <= phi_end, from the inside out.

    ``a`` is in [m], angles are in [rad].
    """
    def arc_length(phi: Array) -> Array:
        return a / 2 * (phi * np.sqrt(1 + phi**2) + np.arcsinh(phi))

    start, end = arc_length(np.array((phi_start, phi_end)))

    def locus(s: Array) -> tuple[Array, Array]:
        total = s + start
        phi = _invert(arc_length, lambda phi: a * np.sqrt(1 + phi**2), total,
                      np.minimum(total / a, np.sqrt(2 * total / a)))
        radial = np.stack((np.cos(phi), np.sin(phi)), axis=1)
        across = np.stack((-radial[:, 1], radial[:, 0]), axis=1)
        tangents = (radial + phi[:, None] * across) / np.sqrt(1 + phi**2)[:, None]
        return a * phi[:, None] * radial, tangents

    return Curve(float(end - start), locus)


def fermat(a: float, phi_max: float) -> Curve:
    """Return both branches of r = +-a sqrt(phi), phi <= phi_max, as one path.

    With the signed radius r as parameter, phi = (r / a)^2, the two branches are one smooth curve
    through the origin. It starts at the outer end of the negative branch. ``a`` is in [m].
    """
    def arc_length(r: Array) -> Array:
        # The integral of sqrt(1 + 4 (r / a)^4); odd in r.
        return np.asarray(r * hyp2f1(-0.5, 0.25, 1.25, -4 * (r / a)**4))

    outer = float(arc_length(np.array(a * np.sqrt(phi_max))))

    def locus(s: Array) -> tuple[Array, Array]:
        total = np.abs(s - outer)
        r = _invert(arc_length, lambda r: np.sqrt(1 + 4 * (r / a)**4), total,
                    np.minimum(total, np.cbrt(1.5 * a**2 * total)))
        r = np.copysign(r, s - outer)
        phi = (r / a)**2
        radial = np.stack((np.cos(phi), np.sin(phi)), axis=1)
        across = np.stack((-radial[:, 1], radial[:, 0]), axis=1)
        tangents = ((radial + 2 * phi[:, None] * across)
                    / np.sqrt(1 + 4 * phi**2)[:, None])
        return r[:, None] * radial, tangents

    return Curve(2 * outer, locus)


def _invert(function: Callable[[Array], Array], derivative: Callable[[Array], Array],
            values: Array, upper: Array) -> Array:
    """Find where a convex increasing function takes values (N,), by Newton from upper bounds (N,).

    From above, the iteration falls monotonically: it needs no safeguard.
    """
    x = upper
    for _ in range(50):
        step = (function(x) - values) / derivative(x)
        x = x - step
        if np.all(np.abs(step) <= 1e-15 * np.abs(x) + 1e-300):
            break
    return x
