"""A syringe extruder with faults: what leaves the nozzle, and the bead that it makes.

Constants are those that others have measured or use:

- A compliant syringe is a first-order lag, tau dQ/dt + Q = Q_commanded. Klipper's pressure advance
  takes tau from 0.05 to 1 s, camera data of a plastic extruder gives 0.25 to 0.37 s, and soft
  syringes with tubes take 10 s and more to settle.
- Pneumatic dispensers have a dead time of 0.15 s.
- The width of printed lines varies by 7 to 23 % along a line, with an autocorrelation of 0.82
  from one sample to the next (series published with arXiv:2201.11819); a sample is taken to be a
  millimetre. Instead of this, an unevenness as measured may be taken (``unevenness``).
- A bead of flow Q, laid at speed v and spread k-fold, is w = k sqrt(4 Q / (pi v)) wide.
"""

from __future__ import annotations

from array import array
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.signal import lfilter

from bpc_perception.core.arrays import Array
from bpc_sim.ink.unevenness import Unevenness

NOISE_CORRELATION = 0.82  # of the width, from one millimetre to the next
NOISE_STEP_M = 2e-4  # between values of the noise
SMALLEST_NOISE_FACTOR = 0.2  # on the width
CORNER_RECOVERY_M = 1e-3  # length over which the bead recovers from a corner
THINNEST_BEAD_M = 3e-4  # a bead tears where it would be thinner
BLOB_LENGTH_M = 1e-3  # over which ink lies that was pushed out before the nozzle moved

# From arc lengths of any shape [m] to factors on the flow of the same shape.
Delivery = Callable[[Array], Array]


def full_delivery(s: Array) -> Array:
    """Return 1 at all arc lengths s: all commanded ink arrives."""
    return np.ones(np.shape(s))


@dataclass(frozen=True, eq=False)
class ExtruderBehaviour:
    """How an extruder deviates from its command.

    Attributes:
        lag: time constant of the syringe's compliance [s].
        dead_time: time before a change of the command has any effect [s].
        delivery: share of the commanded flow that arrives, over arc length.
        noise: coefficient of variation of the width.
        bubbles: (B, 2) arc lengths between which air comes instead of ink [m].
        corners: (C,) arc lengths of corners [m]; behind a corner the nozzle drags the bead.
        drag: how much thinner the bead is at a corner, as a fraction.
        spreading: width of the bead over the diameter of a round bead.
        seed: seed of the noise.
        unevenness: of the width, instead of the noise; None = the noise.
        layer: number of the layer, from 1; parts of an unevenness may repeat from layer to layer.
    """

    lag: float = 0.3
    dead_time: float = 0.15
    delivery: Delivery = full_delivery
    noise: float = 0.02
    bubbles: Array = field(default_factory=lambda: np.empty((0, 2)))
    corners: Array = field(default_factory=lambda: np.empty(0))
    drag: float = 0.2
    spreading: float = 1.6
    seed: int = 0
    unevenness: Unevenness | None = None
    layer: int = 1

    def flow_for(self, width: float, speed: float) -> float:
        """Return the flow [m^3/s] for a width [m] at a speed [m/s] if all ink arrives."""
        return float(np.pi / 4 * (width / self.spreading)**2 * speed)

    @property
    def height_ratio(self) -> float:
        """Height of the bead over its width: a parabola of area 2/3 w h holds the laid volume."""
        return float(3 / 8 * np.pi / self.spreading**2)


class Extrusion:
    """Ink as it is laid, from the positions of the nozzle and the commands to the extruder.

    Args:
        behaviour: how the extruder deviates from its command.
        length: arc length of the path [m].
    """

    def __init__(self, behaviour: ExtruderBehaviour, length: float) -> None:
        self.behaviour = behaviour
        self.delivered = 0.0  # flow behind the compliance [m^3/s]
        self._length = length
        self._time = self._s = -np.inf
        self._commands: deque[tuple[float, float]] = deque([(-np.inf, 0.0)])
        # Where beads lie [m], and how wide they are [m]; NumPy takes these at once.
        self._places, self._widths = array('d'), array('d')
        self._primed = 0.0  # volume that came while the nozzle stood at the beginning [m^3]

    def advance(self, time: float, s: float, flow: float) -> None:
        """Go on to a time [s] at which the nozzle is at arc length s [m].

        Since the previous time, the command was ``flow`` [m^3/s]. Times have to increase.
        """
        behaviour, step = self.behaviour, time - self._time
        if np.isfinite(step):
            self._commands.append((self._time, flow))
            while len(self._commands) > 1 and self._commands[1][0] <= time - behaviour.dead_time:
                self._commands.popleft()
            share = -np.expm1(-step / behaviour.lag)
            self.delivered += share * (self._commands[0][1] - self.delivered)
            if s > self._s:
                bead = 4 / np.pi * self.delivered * step / (s - self._s)
                self._places.append((s + self._s) / 2)
                self._widths.append(behaviour.spreading * bead**0.5)
            elif not self._places:  # later the nozzle is lifted where it stands
                self._primed += self.delivered * step
        self._time, self._s = time, s

    def width(self, s: Array) -> Array:
        """Return the width (N,) of the ink at arc lengths s (N,) [m]; 0 where there is none."""
        if not self._places:
            return np.zeros(np.shape(s))
        behaviour = self.behaviour
        width = np.interp(s, np.array(self._places), np.array(self._widths))
        primed = np.where(s < self._places[0] + BLOB_LENGTH_M, self._primed / BLOB_LENGTH_M, 0.0)
        width = np.sqrt(width**2 + behaviour.spreading**2 * 4 / np.pi * primed)
        width *= np.sqrt(behaviour.delivery(s))
        width *= np.interp(s, *self._noise)
        behind = s[:, None] - behaviour.corners
        dragged = np.where(behind >= 0, np.exp(-np.abs(behind) / CORNER_RECOVERY_M), 0.0)
        width *= 1 - behaviour.drag * dragged.max(axis=1, initial=0.0)
        start, end = behaviour.bubbles.T
        missing = ((s[:, None] >= start) & (s[:, None] < end)).any(axis=1)
        return np.where(missing | (width < THINNEST_BEAD_M) | (s > self._s), 0.0, width)

    @cached_property
    def _noise(self) -> tuple[Array, Array]:
        """Arc lengths (K,) [m] and factors (K,) on the width."""
        s = np.arange(0.0, self._length + 2 * NOISE_STEP_M, NOISE_STEP_M)
        behaviour = self.behaviour
        factors = (self._assumed(len(s)) if behaviour.unevenness is None
                   else behaviour.unevenness.factors(len(s), NOISE_STEP_M, behaviour.seed,
                                                     behaviour.layer))
        return s, np.maximum(factors, SMALLEST_NOISE_FACTOR)

    def _assumed(self, count: int) -> Array:
        """Factors (count,) on the width, autoregressive of first order."""
        rng = np.random.default_rng(self.behaviour.seed)
        keep = NOISE_CORRELATION**(NOISE_STEP_M / 1e-3)
        shocks = rng.standard_normal(count) * np.sqrt(1 - keep**2)
        shocks[0] = rng.standard_normal()
        return np.asarray(1 + self.behaviour.noise * lfilter([1.0], [1.0, -keep], shocks))
