"""Beds that are printed on: a plane, or a cylinder.

A place on a bed has two coordinates along it, in which curves and deposits are given, and a
height above it along the normal. The surface frame touches the bed at place (0, 0), its z axis
the outward normal there; on the plane, places and heights are its coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from bpc_perception.core.arrays import Array


class Surface(Protocol):
    """A bed; rays are those of a camera at ``eye`` (3,), all in the surface frame."""

    def points(self, places: Array, height: Array) -> Array:
        """Points (N, 3) [m] at places (N, 2) [m] and heights (N,) [m]."""

    def axes(self, places: Array) -> Array:
        """Rows (N, 3, 3): directions of both coordinates and the normal at places (N, 2)."""

    def meet(self, eye: Array, directions: Array, height: Array) -> tuple[Array, Array, Array]:
        """Where rays along directions (N, M, 3) come down to a height (N, M) [m].

        Returns:
            The places (N, M, 2); how far a ray moves along the bed per height there (N, M, 2);
            and how many times its direction it has come (N, M). NaN where it misses.
        """


@dataclass(frozen=True)
class Plane:
    """A flat bed."""

    def points(self, places: Array, height: Array) -> Array:
        """As of Surface."""
        return np.concatenate((places, height[:, None]), axis=1)

    def axes(self, places: Array) -> Array:
        """As of Surface."""
        return np.broadcast_to(np.eye(3), (len(places), 3, 3))

    def meet(self, eye: Array, directions: Array, height: Array) -> tuple[Array, Array, Array]:
        """As of Surface."""
        fall = np.where(directions[..., 2] < 0, directions[..., 2], np.nan)
        depth = -eye[2] / fall
        ground = eye[:2] + depth[..., None] * directions[..., :2]
        lean = directions[..., :2] / fall[..., None]
        return ground + lean * height[..., None], lean, depth * (1 - height / eye[2])


@dataclass(frozen=True)
class Cylinder:
    """The outside of a cylinder along the first coordinate; the second goes around it.

    Attributes:
        radius: [m].
    """

    radius: float

    def points(self, places: Array, height: Array) -> Array:
        """As of Surface."""
        angle, reach = places[:, 1] / self.radius, self.radius + height
        return np.stack((places[:, 0], reach * np.sin(angle),
                         reach * np.cos(angle) - self.radius), axis=1)

    def axes(self, places: Array) -> Array:
        """As of Surface."""
        angle = places[:, 1] / self.radius
        axes = np.zeros((len(places), 3, 3))
        axes[:, 0, 0] = 1.0
        axes[:, 1, 1] = axes[:, 2, 2] = np.cos(angle)
        axes[:, 2, 1] = np.sin(angle)
        axes[:, 1, 2] = -axes[:, 2, 1]
        return axes

    def meet(self, eye: Array, directions: Array, height: Array) -> tuple[Array, Array, Array]:
        """As of Surface."""
        reach = self.radius + height
        dy, dz = directions[..., 1], directions[..., 2]
        y0, z0 = eye[1], eye[2] + self.radius
        a, half_b, c = dy**2 + dz**2, dy * y0 + dz * z0, y0**2 + z0**2 - reach**2
        discriminant = half_b**2 - a * c
        root = np.sqrt(np.where(discriminant > 0, discriminant, np.nan))
        depth = (-half_b - root) / a
        y, z = (y0 + depth * dy) / reach, (z0 + depth * dz) / reach
        rise = dy * y + dz * z  # away from the axis; < 0, as it is the near side
        places = np.stack((eye[0] + depth * directions[..., 0],
                           self.radius * np.arctan2(y, z)), axis=-1)
        lean = np.stack((directions[..., 0], (dy * z - dz * y) * self.radius / reach), axis=-1)
        return places, lean / rise[..., None], depth
