"""How a picture is exposed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture, pixels_around

CLIPPED = 254  # grey levels; the camera says no more than 255
PROBES = 60  # places along a path


@dataclass(frozen=True)
class Exposure:
    """How pixels are exposed.

    Attributes:
        clipped: share of those in which a channel is clipped.
        bright: brightness that one in a hundred exceeds [grey levels].
    """

    clipped: float
    bright: float

    @classmethod
    def of(cls, pixels: NDArray[np.uint8]) -> Exposure:
        """Return the exposure of pixels (..., 3); of none, NaN."""
        colours = pixels.reshape(-1, 3)
        if not len(colours):
            return cls(float('nan'), float('nan'))
        brightness = colours.mean(axis=1)
        return cls(float((colours >= CLIPPED).any(axis=1).mean()),
                   float(np.quantile(brightness, 0.99)))


def around(capture: Capture, uv: Array) -> NDArray[np.uint8]:
    """Return pixels (K, 3) of the image around places uv (N, 2) in it; NaN = nowhere."""
    seen = uv[np.isfinite(uv).all(axis=1)]
    u, v = pixels_around(seen[::max(1, len(seen) // PROBES)], capture.camera)
    return np.asarray(capture.image[v, u])
