"""Rigid transforms and planes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array


def transform(T_target_source: Array, points: Array) -> Array:
    """Take points (..., 3) from the source frame to the target frame of a 4x4 transform."""
    return points @ T_target_source[:3, :3].T + T_target_source[:3, 3]


def invert(T_target_source: Array) -> Array:
    """The inverse T_source_target of a rigid 4x4 transform."""
    R = T_target_source[:3, :3]
    T_source_target = np.eye(4)
    T_source_target[:3, :3] = R.T
    T_source_target[:3, 3] = -R.T @ T_target_source[:3, 3]
    return T_source_target


@dataclass(frozen=True)
class Plane:
    """The points p with ``normal @ p + offset == 0``; ``normal`` (3,) has unit length."""

    normal: Array
    offset: float

    def height(self, points: Array) -> Array:
        """Signed distance (...,) of points (..., 3), positive on the normal's side."""
        return points @ self.normal + self.offset

    def project(self, points: Array) -> Array:
        """The feet (..., 3) of the perpendiculars from points (..., 3)."""
        return points - self.height(points)[..., None] * self.normal

    def coordinates(self, points: Array) -> Array:
        """In-plane coordinates (..., 2) of the projections of points (..., 3) [m]."""
        helper = np.eye(3)[np.argmin(np.abs(self.normal))]
        e1 = np.cross(self.normal, helper)
        e1 /= np.linalg.norm(e1)
        return points @ np.stack((e1, np.cross(self.normal, e1)), axis=1)


def unit_vectors(vectors: Array) -> Array:
    """Vectors (..., 3) of length 1; NaN where there is no length."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, np.nan)
