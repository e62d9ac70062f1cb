"""From the light that reaches the pixels to the image that a camera delivers."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array

Colour = tuple[float, float, float]  # RGB, 0..255

FULL_COVERAGE = 0.99  # a pixel with more ink counts as ink
GLARE_LEVEL = 500.0  # grey levels in the middle of a reflection: far beyond saturation
GLARE_RADIUS_PX = (1.0, 2.5)  # smallest and largest, where it has fallen to 1 / e


@dataclass(frozen=True)
class Imaging:
    """Colours of the scene, and imperfections of lamp, lens and sensor.

    Attributes:
        ink, bed: colours, RGB, 0..255.
        lamp_gradient: brightness falls from 1 + this to 1 - this along the diagonal of the image.
        glare_spots: number of saturated reflections on the ink, each a few pixels wide.
        blur: standard deviation of the lens' point spread [pixels].
        noise: standard deviation of the sensor's noise [grey levels].
    """

    ink: Colour = (40.0, 80.0, 170.0)
    bed: Colour = (205.0, 205.0, 200.0)
    lamp_gradient: float = 0.0
    glare_spots: int = 0
    blur: float = 0.0
    noise: float = 0.0


def mix(ink: Array | Colour, bed: Array | Colour, coverage: Array) -> Array:
    """Return the colours (..., 3) of pixels of which ink covers a fraction (...)."""
    weight = coverage[..., None]
    return weight * np.asarray(ink) + (1 - weight) * np.asarray(bed)


def expose(light: Array, coverage: Array, imaging: Imaging,
           rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return the image (H, W, 3) RGB that the sensor takes of the light in the scene.

    Args:
        light: (H, W, 3) RGB, 0..255.
        coverage: (H, W) fraction of ink in each pixel: glare is on ink only.
        imaging: imperfections of lamp, lens and sensor.
        rng: source of glare and noise.
    """
    height, width = coverage.shape
    v, u = np.mgrid[0:height, 0:width]
    if imaging.lamp_gradient:
        diagonal = (u / max(width - 1, 1) + v / max(height - 1, 1)) - 1
        light = light * (1 - imaging.lamp_gradient * diagonal)[..., None]
    ink = np.flatnonzero(coverage.ravel() > FULL_COVERAGE)
    if imaging.glare_spots and len(ink):
        light = light.copy()
        for spot in rng.choice(ink, imaging.glare_spots):
            radius = rng.uniform(*GLARE_RADIUS_PX)
            distance = np.hypot(u - spot % width, v - spot // width)
            light += GLARE_LEVEL * np.exp(-(distance / radius)**2)[..., None]
    light = np.minimum(light, 255.0)
    if imaging.blur:
        light = np.asarray(cv2.GaussianBlur(light, (0, 0), imaging.blur), np.float64)
    if imaging.noise:
        light = light + rng.normal(0.0, imaging.noise, light.shape)
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)
