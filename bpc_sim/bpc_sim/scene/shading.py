"""How much of the lamp's light bed and ink scatter and reflect."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.scene.ray_tracing import InkHits
from bpc_sim.scene.surfaces import Surface

GLOSS_EXPONENT = 80  # of the reflection on wet ink: the larger, the narrower the highlight


@dataclass(frozen=True, eq=False)
class InkLight:
    """Light of the bead as fractions, arrays (N, M); without ink 1 and 0.

    Attributes:
        diffuse: scattered light; 1 = as much as the bed scatters where it is level.
        reflected: reflection of the lamp into the camera.
    """

    diffuse: Array
    reflected: Array


def light_on_bed(surface: Surface, ground: Array, lamp: Array) -> Array:
    """Return the light (N,) that the bed scatters; 1 where the bed is level as its frame is.

    Args:
        surface: the bed.
        ground: (N, 2) places on the bed [m]; NaN where a ray misses it.
        lamp: (3,) position of the lamp in the surface frame [m].
    """
    light = np.ones(len(ground))
    hit = np.flatnonzero(np.isfinite(ground[:, 0]))
    to_lamp = _unit(lamp - surface.points(ground[hit], np.zeros(len(hit))))
    upward = surface.axes(ground[hit])[:, 2]
    light[hit] = np.clip((upward * to_lamp).sum(axis=1) / to_lamp[:, 2], 0, None)
    return light


def light_on_ink(surface: Surface, hits: InkHits, ground: Array, eye: Array,
                 lamp: Array) -> InkLight:
    """Return the light that the bead scatters and reflects.

    Args:
        surface: the bed.
        hits: where rays meet the ink, arrays (N, M).
        ground: (N, M, 2) places on the bed below the hits [m].
        eye: (3,) the camera's centre in the surface frame [m].
        lamp: (3,) position of the lamp in the surface frame [m].
    """
    diffuse, reflected = np.ones(hits.hit.shape), np.zeros(hits.hit.shape)
    ink = hits.hit
    slope, heading = hits.slope[ink], hits.heading[ink]
    normal = _unit(np.stack((slope * np.sin(heading), -slope * np.cos(heading),
                             np.ones(len(slope))), axis=1))
    normal = np.einsum('ij,ijk->ik', normal, surface.axes(ground[ink]))
    point = surface.points(ground[ink], hits.height[ink])
    to_lamp, to_eye = _unit(lamp - point), _unit(eye - point)
    diffuse[ink] = np.clip((normal * to_lamp).sum(axis=1) / to_lamp[:, 2], 0, None)
    reflected[ink] = np.clip(
        (normal * _unit(to_lamp + to_eye)).sum(axis=1), 0, None)**GLOSS_EXPONENT
    return InkLight(diffuse, reflected)


def _unit(vectors: Array) -> Array:
    """Return vectors (N, 3) of unit length along vectors (N, 3)."""
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
