"""Area-sampled drawing of shapes on a plane: what an ideal sensor sees from straight above.

Pixel (u, v) is the point ((u - u0) p, -(v - v0) p) of the plane, where (u0, v0) is the centre of
the square image and p the size of a pixel: x points right, y up.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bpc_perception.core.arrays import Array

# From points (N, 2) or (N, M, 2) [m] to about their distance from a shape [m], negative inside.
Margin = Callable[[Array], Array]


def to_points(pixels: Array, size: int, pixel_size: float) -> Array:
    """Return points (N, 2) of the plane [m] at pixels (N, 2) of an image of size x size pixels."""
    return (pixels - (size - 1) / 2) * (1.0, -1.0) * pixel_size


def pixel_centres(size: int, pixel_size: float) -> Array:
    """Return points (size * size, 2) of the plane [m] at the pixels' centres, row by row."""
    v, u = np.mgrid[0:size, 0:size].reshape(2, -1)
    return to_points(np.stack((u, v), axis=1).astype(np.float64), size, pixel_size)


def subpixel_offsets(count: int) -> Array:
    """Return offsets (count * count, 2) of a grid of points from a pixel's centre [pixels]."""
    steps = (np.arange(count) + 0.5) / count - 0.5
    return np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)


def coverage(shape: Margin, size: int, pixel_size: float, supersample: int = 8) -> Array:
    """Return the fraction (size, size) of each pixel that a shape covers.

    In a pixel that an edge may cross it is that of ``supersample`` x ``supersample`` points.
    """
    centres = pixel_centres(size, pixel_size)
    margin = shape(centres)
    covered = (margin <= 0).astype(np.float64)
    edge = np.flatnonzero(np.abs(margin) < pixel_size)
    grid = subpixel_offsets(supersample) * pixel_size
    covered[edge] = (shape(centres[edge, None] + grid) <= 0).mean(axis=1)
    return covered.reshape(size, size)
