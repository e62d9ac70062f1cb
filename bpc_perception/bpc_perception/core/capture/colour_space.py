"""What the levels of an image say of the light.

A lens blurs light: an edge lies where half of it is reached, whatever the levels say. So levels
that are coded for a screen are put back into proportion to the light.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LINEAR, SRGB = 'linear_rgb', 'srgb'  # as Zivid's node calls them
COLOUR_SPACES = LINEAR, SRGB
WHITE = 255.0  # the highest level


def light_of_levels(colour_space: str) -> NDArray[np.float32]:
    """Return the light (256,) of each level, 0 to 255 [IEC 61966-2-1]."""
    level = np.arange(256) / WHITE
    if colour_space == SRGB:
        level = np.where(level <= 0.04045, level / 12.92, ((level + 0.055) / 1.055)**2.4)
    return np.asarray(WHITE * level, np.float32)


LIGHT = {space: light_of_levels(space) for space in COLOUR_SPACES}
