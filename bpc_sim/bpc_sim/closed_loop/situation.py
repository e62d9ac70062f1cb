"""A print and what goes wrong with it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.targets import WidthTargets
from bpc_sim.ink.deposit import WidthProfile
from bpc_sim.ink.extrusion import ExtruderBehaviour

NOMINAL_WIDTH_M = 2e-3
NOMINAL_SPEED_M_PER_S = 3e-3  # the paper's
LAYER_SEEDS = 100_003  # from the seed of a layer to that of the next
OTHER_INK_LAYER = 3  # from which on another ink is printed


def constant_speed(s: Array) -> Array:
    """Return the nominal speed at arc lengths s of any shape [m/s]."""
    return np.full(np.shape(s), NOMINAL_SPEED_M_PER_S)


@dataclass(frozen=True, eq=False)
class Situation:
    """A print and what goes wrong with it.

    Attributes:
        name: name of the scenario.
        behaviour: how the extruder deviates from its command.
        targets: wanted width along the path.
        length: arc length of the path [m].
        speed: nominal speed over arc length [m/s].
        width: width for which the nominal flow is right [m].
        period: time from capture to capture [s].
        acquisition: duration of a capture [s]; its stamp is the end.
        latency: time from the stamp until the advice arrives [s].
        event: arc length at which the deviation begins that has to be corrected [m].
        fault: arc length from which on an alarm is due [m].
        fault_shows_in_bead: whether the fault shows in the bead only: it cannot be known before
            that bead is seen.
        camera_lost, path_lost, extruder_lost: arc lengths from which on there are no captures, no
            path and no ink [m].
        offset: distance of the bead from the path, as by a wrong calibration [m].
        strokes: (S, 2) arc lengths between which ink is wanted [m]; None = everywhere.
        noise_repeats: whether the bead is uneven at the same places in each layer, as a printer's
            own faults make it; else it is chance.
        other_ink: gain and lag of the ink from the third layer on, relative to that before.
        seed: seed of the camera's noise.
    """

    name: str
    behaviour: ExtruderBehaviour
    targets: WidthTargets = field(
        default_factory=lambda: WidthTargets.constant(NOMINAL_WIDTH_M))
    length: float = 0.3
    speed: WidthProfile = constant_speed
    width: float = NOMINAL_WIDTH_M
    period: float = 1.0
    acquisition: float = 0.25
    latency: float = 0.3
    event: float = 0.0
    fault: float = np.inf
    fault_shows_in_bead: bool = False
    camera_lost: float = np.inf
    path_lost: float = np.inf
    extruder_lost: float = np.inf
    offset: float = 0.0
    strokes: Array | None = None
    noise_repeats: bool = True
    other_ink: tuple[float, float] = (1.0, 1.0)
    seed: int = 0

    def in_layer(self, layer: int) -> Situation:
        """Return the situation in a layer, from 1: other noise of the camera, and of the ink."""
        behaviour = replace(self.behaviour, layer=layer)
        if not self.noise_repeats:
            behaviour = replace(behaviour, seed=behaviour.seed + LAYER_SEEDS * (layer - 1))
        if layer >= OTHER_INK_LAYER and self.other_ink != (1.0, 1.0):
            gain, lag = self.other_ink
            usual = behaviour.delivery
            behaviour = replace(behaviour, lag=behaviour.lag * lag,
                                delivery=lambda s: gain * usual(s))
        return replace(self, behaviour=behaviour, seed=self.seed + LAYER_SEEDS * (layer - 1))

    def wanted(self, s: Array) -> Flags:
        """Return where (N,) of arc lengths (N,) [m] ink is wanted."""
        if self.strokes is None:
            return np.ones(np.shape(s), bool)
        return np.asarray(((s[:, None] >= self.strokes[:, 0])
                           & (s[:, None] < self.strokes[:, 1])).any(axis=1))
