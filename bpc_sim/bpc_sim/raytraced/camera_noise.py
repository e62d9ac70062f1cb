"""What a camera makes of light and depth: exposure, noise, missing points."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_sim.raytraced.spec import RaytracedScene

EXPOSED_PERCENT, EXPOSED_TO = 99.0, 0.8  # of the pixels are no brighter than this
BLUR_PX = 0.5
SHOT_NOISE, READ_NOISE = 0.02, 1.5  # variance per level, and at level 0 [levels^2]
DEPTH_NOISE_M, DEPTH_NOISE_PX = 4.5e-5, 0.7  # and over how many pixels it is alike
LEAST_COSINE = 0.25  # between view and surface; there are no points beyond
MISSING = 0.003  # share of the points
TOO_DEEP_M = 2e-4  # points of translucent ink
SATURATED = 254


def exposed(scene: RaytracedScene, light: Array) -> NDArray[np.uint8]:
    """Return the picture (H, W, 3) of light (H, W, 3), linear."""
    scale = EXPOSED_TO / np.percentile(light.max(axis=-1), EXPOSED_PERCENT)
    level = 255 * np.clip(scale * cv2.GaussianBlur(light, (0, 0), BLUR_PX), 0, 4)
    rng = scene.rng('image noise')
    level = level + rng.normal(size=level.shape) * np.sqrt(SHOT_NOISE * level + READ_NOISE)
    level = np.clip(level, 0, 255)
    if scene.srgb:
        level = 255 * _coded(level / 255)
    return np.rint(level).astype(np.uint8)


def _coded(linear: Array) -> Array:
    """Return light coded as sRGB [IEC 61966-2-1]."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear**(1 / 2.4) - 0.055)


def depth_seen(scene: RaytracedScene, depth: Array, cosine: Array, on_ink: NDArray[np.bool_],
               image: NDArray[np.uint8]) -> Array:
    """Return depth (H, W) with the camera's noise [m]; NaN where it has no point."""
    rng = scene.rng('depth noise')
    noise = cv2.GaussianBlur(rng.normal(size=depth.shape), (0, 0), DEPTH_NOISE_PX)
    seen = depth + DEPTH_NOISE_M * noise / noise.std()
    if scene.ink.translucent:
        seen = seen + np.where(on_ink, TOO_DEEP_M, 0.0)
    lost = (cosine < LEAST_COSINE) | (image.max(axis=-1) >= SATURATED)
    lost |= rng.random(depth.shape) < MISSING
    return np.where(lost, np.nan, seen)
