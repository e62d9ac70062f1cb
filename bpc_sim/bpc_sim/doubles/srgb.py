"""Images in sRGB and in proportion to the light [IEC 61966-2-1]."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array


def srgb_to_linear(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return an sRGB image of any shape as one in proportion to the light, 0..255."""
    share = image / 255.0
    light: Array = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055)**2.4)
    return np.rint(255 * light).astype(np.uint8)


def linear_to_srgb(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return an image in proportion to the light, of any shape, as an sRGB image, 0..255."""
    light = image / 255.0
    share: Array = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light**(1 / 2.4) - 0.055)
    return np.rint(255 * share).astype(np.uint8)
