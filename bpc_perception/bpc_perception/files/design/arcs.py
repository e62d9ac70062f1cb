"""Arcs of G-code as chords."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.files.design.refusals import refusal

CHORD_MM = 0.005  # how far a chord may be from its arc
# How far the ends may be from one circle, as numbers in a file are rounded.
UNROUND_MM, UNROUND = 0.02, 1e-3
LARGEST_RADIUS_MM = 1e4
LEAST_CHORDS = 8  # of a circle, however small


@dataclass(frozen=True)
class Arc:
    """A command G2 or G3 in the plane of x and y, as in RS274/NGC (NIST IR 6556, section 3.5.3).

    Attributes:
        start, end: (3,) [mm].
        clockwise: whether it is G2, seen from above.
        i, j: from the start to the centre [mm]; None = not given.
        radius: [mm], negative for the longer way round; None = not given.
        line: number of its line.
    """

    start: Array
    end: Array
    clockwise: bool
    i: float | None
    j: float | None
    radius: float | None
    line: int

    def points(self) -> Array:
        """Return the ends (K, 3) of chords, without the start [mm].

        z rises evenly. The ends may be so little apart in radius as rounding explains; the radius
        changes evenly then. Raises DesignError where there is no such arc.
        """
        centre = self._centre()
        one, other = self.start[:2] - centre, self.end[:2] - centre
        first, last = np.hypot(*one), np.hypot(*other)
        if first == 0 or not abs(first - last) <= UNROUND_MM + UNROUND * first:
            raise refusal(self.line, 'an arc whose ends are as far from its centre',
                          f'{first:.3f} and {last:.3f} mm', 'correct I and J, or the end')
        if first > LARGEST_RADIUS_MM:
            raise refusal(self.line, f'a radius up to {LARGEST_RADIUS_MM:g} mm',
                          f'{first:.0f} mm', 'write it as a line')
        begin = np.arctan2(one[1], one[0])
        turn = (np.arctan2(other[1], other[0]) - begin) % (2 * np.pi)
        if self.clockwise:
            turn -= 2 * np.pi
        if np.allclose(self.start[:2], self.end[:2], rtol=0, atol=1e-9):
            turn = -2 * np.pi if self.clockwise else 2 * np.pi
        step = 2 * np.arccos(1 - min(CHORD_MM / first, 1 - np.cos(np.pi / LEAST_CHORDS)))
        share = np.linspace(0, 1, 1 + max(int(np.ceil(abs(turn) / step)), 1))[1:, None]
        angle, radius = begin + share * turn, first + share * (last - first)
        found = np.hstack((centre + radius * np.hstack((np.cos(angle), np.sin(angle))),
                           self.start[2:] + share * (self.end[2:] - self.start[2:])))
        found[-1] = self.end
        return np.asarray(found)

    def _centre(self) -> Array:
        """Return the centre (2,) [mm]."""
        given = self.i is not None or self.j is not None
        if given == (self.radius is not None):
            raise refusal(self.line, 'an arc with I and J, or with R',
                          'both' if given else 'neither', 'write one of them')
        if self.radius is None:
            return np.add(self.start[:2], (self.i or 0.0, self.j or 0.0))
        chord = self.end[:2] - self.start[:2]
        length = float(np.hypot(*chord))
        if length < 1e-9:
            raise refusal(self.line, 'an arc with R that ends elsewhere', 'one that ends where '
                          'it starts', 'write I and J for a circle')
        above = self.radius**2 - length**2 / 4
        if above < -UNROUND_MM * abs(self.radius):
            raise refusal(self.line, f'a radius of {length / 2:.3f} mm or more',
                          f'{abs(self.radius):.3f} mm', 'correct R, or the end')
        left = np.array((-chord[1], chord[0])) / length
        side = -1 if self.clockwise == (self.radius > 0) else 1
        return np.asarray(self.start[:2] + chord / 2 + side * np.sqrt(max(above, 0.0)) * left)
