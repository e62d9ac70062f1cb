"""Area-sampled drawing of shapes on the plane: what an ideal sensor sees straight from above.

Pixel (u, v) is the point ((u - u0) p, -(v - v0) p) of the plane, with the centre (u0, v0) of the
square image and the pixel size p: x points right, y up.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bpc_perception.core.arrays import Array

# Points (N, 2) or (N, M, 2) [m] to about their distance from a shape [m], negative inside.
Margin = Callable[[Array], Array]


def to_points(pixels: Array, size: int, pixel_size: float) -> Array:
    """Points (N, 2) of the plane [m] at pixels (N, 2) of an image of size x size pixels."""
    return (pixels - (size - 1) / 2) * (1.0, -1.0) * pixel_size


def pixel_centres(size: int, pixel_size: float) -> Array:
    """Points (size * size, 2) of the plane [m] at the pixels' centres, row by row."""
    v, u = np.mgrid[0:size, 0:size].reshape(2, -1)
    return to_points(np.stack((u, v), axis=1).astype(np.float64), size, pixel_size)


def coverage(shape: Margin, size: int, pixel_size: float, supersample: int = 8) -> Array:
    """Fraction (size, size) of each pixel in a shape, from ``supersample``^2 points a pixel."""
    centres = pixel_centres(size, pixel_size)
    margin = shape(centres)
    covered = (margin <= 0).astype(np.float64)
    edge = np.flatnonzero(np.abs(margin) < pixel_size)
    steps = (np.arange(supersample) + 0.5) / supersample - 0.5
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2) * pixel_size
    covered[edge] = (shape(centres[edge, None] + grid) <= 0).mean(axis=1)
    return covered.reshape(size, size)
