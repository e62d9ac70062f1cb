"""How uneven a bead is along the path, as measured on real lines.

The constants are those of eight lines of a thin resin, filmed at 45 frames a second while they
were laid at 4.5 to 6.5 mm/s (github.com/leanfried/in-situ-monitoring-of-direct-ink-writing): of
the reach of the ink beneath the nozzle, the series with the fewest gaps. How they were found, and
what they do not tell, is in docs/figures/closed_loop.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Protocol

import numpy as np
from scipy.signal import lfilter

from bpc_perception.core.arrays import Array
from bpc_perception.core.parameter import Config, Parameter

OWN, WAVE, SHARED = 1, 2, 3  # what is random, with its own seed


class Unevenness(Protocol):
    """Factors on the width, from the beginning of a path on."""

    def factors(self, count: int, step: float, seed: int, layer: int) -> Array:
        """Return factors (count,) on the width, a step [m] apart, of a printer and a layer."""
        ...


@dataclass(frozen=True)
class MeasuredUnevenness(Config):
    """A wave that forgets its phase, and a slow change that partly repeats from layer to layer.

    The factor is 1 + w + c. At a distance d, the autocorrelation of the wave w is
    exp(-d / memory) cos(2 pi d / wavelength), that of the slow change c is
    exp(-d / slow_length). Both are Gaussian. The wave is another one in each layer.
    """

    wave: Annotated[float, Parameter(
        'Coefficient of variation by the wave', '', 0, 0.5)] = 0.098
    wavelength: Annotated[float, Parameter('From crest to crest', 'm', 1e-3, 1)] = 2.49e-3
    memory: Annotated[float, Parameter(
        'Length in which the wave forgets its phase', 'm', 1e-4, 1)] = 9.0e-3
    slow: Annotated[float, Parameter(
        'Coefficient of variation by the slow change; 50 mm of it vary half as much', '', 0,
        0.5)] = 0.070
    slow_length: Annotated[float, Parameter(
        'Length in which the slow change fades', 'm', 1e-3, 10)] = 0.05
    repeats: Annotated[float, Parameter(
        'Correlation of the slow change with that of another layer at the same place',
        '', 0, 1)] = 0.7

    def factors(self, count: int, step: float, seed: int, layer: int) -> Array:
        """Return factors (count,) on the width, a step [m] apart."""
        fade = np.exp(-step / self.slow_length)
        shared, own = (first_order(np.random.default_rng((seed, *key)), count, fade).real
                       for key in ((0, SHARED), (layer, OWN)))
        slow = np.sqrt(self.repeats) * shared + np.sqrt(1 - self.repeats) * own
        # A complex process of first order turns while it forgets.
        turn = np.exp(-step / self.memory + 2j * np.pi * step / self.wavelength)
        wave = first_order(np.random.default_rng((seed, layer, WAVE)), count, turn)
        return np.asarray(1 + self.wave * wave.real + self.slow * slow)


def first_order(rng: np.random.Generator, count: int, keep: complex) -> Array:
    """Return a stationary autoregression of first order (count,); each part has variance 1.

    A longer one begins with the same values, so that layers of any length share what repeats.

    Args:
        rng: gives the shocks.
        count: number of values.
        keep: what a value keeps of the one before, below 1 in size; complex values turn by it.
    """
    parts = rng.standard_normal((count, 2))
    shocks = parts[:, 0] + 1j * parts[:, 1]
    shocks[1:] *= np.sqrt(1 - abs(keep)**2)
    return np.asarray(lfilter([1.0], [1.0, -keep], shocks))
