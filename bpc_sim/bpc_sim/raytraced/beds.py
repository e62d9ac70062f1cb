"""Pictures of beds, made of noise and lines."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.raytraced.looks import Bed

SIZE_PX = 2048
PIXELS_PER_MM = 14.0
WIDTH_M = SIZE_PX / PIXELS_PER_MM * 1e-3


def noise(rng: np.random.Generator, *sizes_mm: float) -> Array:
    """Return a picture (SIZE_PX, SIZE_PX) of mean 0 and deviation 1, with blobs of such sizes."""
    layers = []
    for size in sizes_mm:
        sigma = max(size * PIXELS_PER_MM / 2, 0.5)
        step = max(1, int(sigma / 2))
        small = rng.normal(size=(SIZE_PX // step + 1,) * 2)
        layer = cv2.GaussianBlur(small, (0, 0), sigma / step)
        layer = cv2.resize(layer, (SIZE_PX, SIZE_PX), interpolation=cv2.INTER_CUBIC)
        layers.append(layer / layer.std())
    total = np.sum(layers, axis=0)
    return np.asarray(total / total.std())


def tinted(grey: Array, colour: tuple[float, float, float]) -> Array:
    """Return a picture (H, W, 3) of a colour, lighter or darker as grey (H, W) says."""
    return np.clip(grey[..., None] * np.array(colour), 0.004, 0.95)


def paper(rng: np.random.Generator) -> Array:
    """Return paper: white, with fibres."""
    return tinted(1 + 0.02 * noise(rng, 0.1, 0.3) + 0.015 * noise(rng, 6.0), (0.78, 0.77, 0.73))


def skin(rng: np.random.Generator) -> Array:
    """Return skin: blotches, a few veins, pores."""
    base = tinted(1 + 0.05 * noise(rng, 3.0, 8.0) + 0.03 * noise(rng, 0.3), (0.62, 0.42, 0.32))
    veins = np.exp(-(noise(rng, 9.0) / 0.05)**2)[..., None]
    pores = np.asarray(cv2.GaussianBlur((noise(rng, 0.15) > 2.6).astype(float), (0, 0), 1.0))
    dark = 0.2 * veins * np.array((1.0, 0.6, 0.3)) + 0.3 * pores[..., None]
    return np.clip(base * (1 - dark), 0.01, 0.95)


def tissue(rng: np.random.Generator) -> Array:
    """Return wet tissue: red, mottled."""
    return tinted(1 + 0.12 * noise(rng, 1.5, 5.0) + 0.05 * noise(rng, 0.4), (0.46, 0.14, 0.12))


def metal(rng: np.random.Generator) -> Array:
    """Return brushed metal: streaks along x."""
    streaks = cv2.GaussianBlur(rng.normal(size=(SIZE_PX, SIZE_PX)), (0, 0), 40.0, sigmaY=0.7)
    return tinted(1 + 0.10 * streaks / streaks.std(), (0.56, 0.55, 0.53))


def grid(rng: np.random.Generator) -> Array:
    """Return a dish with a printed millimetre grid, each fifth line broader."""
    place = np.arange(SIZE_PX) / PIXELS_PER_MM
    fine = np.abs(place - np.rint(place)) < 0.05
    broad = np.abs(place / 5 - np.rint(place / 5)) * 5 < 0.1
    line = fine * 0.35 + broad * 0.3
    dark = np.maximum(line[:, None], line[None])
    return tinted((1 - dark) * (1 + 0.015 * noise(rng, 0.2, 4.0)), (0.66, 0.68, 0.66))


def plastic(rng: np.random.Generator) -> Array:
    """Return dark plastic: hardly any texture."""
    return tinted(1 + 0.06 * noise(rng, 0.3, 4.0), (0.035, 0.036, 0.04))


PICTURES: dict[Bed, Callable[[np.random.Generator], Array]] = {
    Bed.PAPER: paper, Bed.SKIN: skin, Bed.TISSUE: tissue, Bed.METAL: metal, Bed.GRID: grid,
    Bed.PLASTIC: plastic}
ROUGHNESS = {Bed.PAPER: 0.8, Bed.SKIN: 0.45, Bed.TISSUE: 0.22, Bed.METAL: 0.35, Bed.GRID: 0.25,
             Bed.PLASTIC: 0.3}
SPECULAR = {Bed.PAPER: 0.1, Bed.SKIN: 0.4, Bed.TISSUE: 0.5, Bed.METAL: 0.5, Bed.GRID: 0.3,
            Bed.PLASTIC: 0.4}
