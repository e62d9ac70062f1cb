"""From the light that reaches the pixels to the image that a camera delivers."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array

Colour = tuple[float, float, float]  # RGB, 0..255


@dataclass(frozen=True)
class Imaging:
    """Colours of the scene and imperfections of lamp, lens and sensor.

    Attributes:
        ink, bed: RGB, 0..255.
        lamp_gradient: brightness falls from 1 + this to 1 - this along the image's diagonal.
        glare_spots: number of reflections that saturate, each a few pixels wide, on the ink.
        blur: sigma of the lens' point spread [pixels].
        noise: sigma of the sensor's noise [grey levels].
    """

    ink: Colour = (40.0, 80.0, 170.0)
    bed: Colour = (205.0, 205.0, 200.0)
    lamp_gradient: float = 0.0
    glare_spots: int = 0
    blur: float = 0.0
    noise: float = 0.0


def mix(ink: Array | Colour, bed: Array | Colour, coverage: Array) -> Array:
    """Colours (..., 3) of pixels that ink covers to a fraction (...)."""
    weight = coverage[..., None]
    return weight * np.asarray(ink) + (1 - weight) * np.asarray(bed)


def expose(light: Array, coverage: Array, imaging: Imaging,
           rng: np.random.Generator) -> NDArray[np.uint8]:
    """The image (H, W, 3) RGB of the light (H, W, 3), 0..255, in the scene.

    ``coverage`` (H, W) tells where ink is, for the glare.
    """
    height, width = coverage.shape
    v, u = np.mgrid[0:height, 0:width]
    if imaging.lamp_gradient:
        diagonal = (u / max(width - 1, 1) + v / max(height - 1, 1)) - 1
        light = light * (1 - imaging.lamp_gradient * diagonal)[..., None]
    ink = np.flatnonzero(coverage.ravel() > 0.99)
    if imaging.glare_spots and len(ink):
        light = light.copy()
        for spot in rng.choice(ink, imaging.glare_spots):
            radius = rng.uniform(1.0, 2.5)
            distance = np.hypot(u - spot % width, v - spot // width)
            light += 500.0 * np.exp(-(distance / radius)**2)[..., None]
    light = np.minimum(light, 255.0)
    if imaging.blur:
        light = np.asarray(cv2.GaussianBlur(light, (0, 0), imaging.blur), np.float64)
    if imaging.noise:
        light = light + rng.normal(0.0, imaging.noise, light.shape)
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)
