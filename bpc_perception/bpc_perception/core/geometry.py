"""Rigid transforms and planes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array


def transform(T_target_source: Array, points: Array) -> Array:
    """Return points (..., 3) of the source frame in the target frame of a transform (4, 4)."""
    return points @ T_target_source[:3, :3].T + T_target_source[:3, 3]


def invert(T_target_source: Array) -> Array:
    """Return the inverse T_source_target (4, 4) of a rigid transform (4, 4)."""
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
        """Return the signed distance (...,) of points (..., 3), positive on the normal's side."""
        return points @ self.normal + self.offset

    def project(self, points: Array) -> Array:
        """Return the feet (..., 3) of the perpendiculars from points (..., 3)."""
        return points - self.height(points)[..., None] * self.normal

    def coordinates(self, points: Array) -> Array:
        """Return in-plane coordinates (..., 2) of the projections of points (..., 3).

        Seen from the tip of the normal, it is counter-clockwise from the first axis to the second.
        """
        helper = np.eye(3)[np.argmin(np.abs(self.normal))]
        e1 = np.cross(self.normal, helper)
        e1 /= np.linalg.norm(e1)
        return points @ np.stack((e1, np.cross(self.normal, e1)), axis=1)


def unit_vectors(vectors: Array) -> Array:
    """Return vectors (..., 3) with length 1; NaN where they have no length."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, np.nan)
