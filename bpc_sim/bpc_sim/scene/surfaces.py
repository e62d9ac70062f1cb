"""Beds to print on: a plane and a cylinder.

A place on a bed has two coordinates along the bed, in which curves and deposits are given, and a
height above the bed along its normal. The surface frame touches the bed at place (0, 0); its z
axis is the outward normal there. On the plane, places and heights are coordinates of that frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from bpc_perception.core.arrays import Array


@dataclass(frozen=True, eq=False)
class SurfaceHits:
    """Where rays come down to a height above a bed; NaN where they miss.

    Attributes:
        places: (N, M, 2) places [m].
        lean: (N, M, 2) how far a ray moves along the bed per height there.
        depth: (N, M) how many times its direction a ray has come.
    """

    places: Array
    lean: Array
    depth: Array


class Surface(Protocol):
    """A bed; rays start at a camera at ``eye`` (3,) [m], all in the surface frame."""

    def points(self, places: Array, height: Array) -> Array:
        """Return the points (N, 3) [m] at places (N, 2) [m] and heights (N,) [m]."""

    def axes(self, places: Array) -> Array:
        """Return the directions of both coordinates and the normal at places (N, 2), as rows.

        The result has shape (N, 3, 3).
        """

    def intersect(self, eye: Array, directions: Array, height: Array) -> SurfaceHits:
        """Find where rays along directions (N, M, 3) come down to a height (N, M) [m]."""


@dataclass(frozen=True)
class Plane:
    """A flat bed."""

    def points(self, places: Array, height: Array) -> Array:
        """Return points; see Surface."""
        return np.concatenate((places, height[:, None]), axis=1)

    def axes(self, places: Array) -> Array:
        """Return axes; see Surface."""
        return np.broadcast_to(np.eye(3), (len(places), 3, 3))

    def intersect(self, eye: Array, directions: Array, height: Array) -> SurfaceHits:
        """Intersect rays with the bed; see Surface."""
        fall = np.where(directions[..., 2] < 0, directions[..., 2], np.nan)
        depth = -eye[2] / fall
        ground = eye[:2] + depth[..., None] * directions[..., :2]
        lean = directions[..., :2] / fall[..., None]
        return SurfaceHits(ground + lean * height[..., None], lean, depth * (1 - height / eye[2]))


@dataclass(frozen=True)
class Cylinder:
    """The outside of a cylinder along the first coordinate; the second goes around it.

    Attributes:
        radius: radius [m].
    """

    radius: float

    def points(self, places: Array, height: Array) -> Array:
        """Return points; see Surface."""
        angle, reach = places[:, 1] / self.radius, self.radius + height
        return np.stack((places[:, 0], reach * np.sin(angle),
                         reach * np.cos(angle) - self.radius), axis=1)

    def axes(self, places: Array) -> Array:
        """Return axes; see Surface."""
        angle = places[:, 1] / self.radius
        axes = np.zeros((len(places), 3, 3))
        axes[:, 0, 0] = 1.0
        axes[:, 1, 1] = axes[:, 2, 2] = np.cos(angle)
        axes[:, 2, 1] = np.sin(angle)
        axes[:, 1, 2] = -axes[:, 2, 1]
        return axes

    def intersect(self, eye: Array, directions: Array, height: Array) -> SurfaceHits:
        """Intersect rays with the bed; see Surface."""
        reach = self.radius + height
        dy, dz = directions[..., 1], directions[..., 2]
        y0, z0 = eye[1], eye[2] + self.radius
        a, half_b, c = dy**2 + dz**2, dy * y0 + dz * z0, y0**2 + z0**2 - reach**2
        discriminant = half_b**2 - a * c
        root = np.sqrt(np.where(discriminant > 0, discriminant, np.nan))
        depth = (-half_b - root) / a
        y, z = (y0 + depth * dy) / reach, (z0 + depth * dz) / reach
        rise = dy * y + dz * z  # away from the axis; negative, since this is the near side
        places = np.stack((eye[0] + depth * directions[..., 0],
                           self.radius * np.arctan2(y, z)), axis=-1)
        lean = np.stack((directions[..., 0], (dy * z - dz * y) * self.radius / reach), axis=-1)
        return SurfaceHits(places, lean / rise[..., None], depth)
