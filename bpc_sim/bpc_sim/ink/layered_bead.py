"""Ink that is laid on ink: what finds no room in height goes to the sides.

The nozzle passes a layer's height above the feet of the layer below. Where that is less than a
bead is high, a bead of the usual section would lie partly in the ink that is there. All of the
ink that was pushed out has to lie above it: the bead is as much larger.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.ink.bead_sizes import sizes_above
from bpc_sim.ink.deposit import Deposit

STEP_M = 2e-4  # between the places at which it is found out
ROUNDS = 8
MOST = 2.0  # times as wide; thin ends of beads lie in the ink below
BELOW = 2  # so many layers may reach up to the next: strands cross, and hang between others


def with_room(ink: Deposit, layers: Array) -> Deposit:
    """Return the ink of a print in layers, with all of it above what lay there before.

    Args:
        ink: with the sections that it has on a bed.
        layers: (L, 2) arc lengths between which each layer is laid [m].
    """
    place = np.arange(0.0, ink.curve.length + STEP_M, STEP_M)
    usual = ink.profile

    def scaled(scale: Array) -> Deposit:
        return replace(ink, profile=lambda s: usual(s) * np.interp(s, place, scale))

    scale = np.ones(len(place))
    for number, (start, end) in enumerate(layers.tolist()):
        own = (place >= start) & (place < end) & ink.inked(place)
        if number == 0 or not own.any():
            continue
        laid = scaled(scale.copy())
        below = [laid.within(*layer) for layer in layers[max(0, number - BELOW):number].tolist()]
        volume = sizes_above(ink, (), place[own])[1]
        for _ in range(ROUNDS):
            bead = scaled(scale.copy()).within(start, end)
            _, area = sizes_above(bead, below, place[own])
            # Its section grows with the square; what lies in the ink below grows more slowly.
            scale[own] = np.minimum(np.sqrt(scale[own]**2 + (volume - area) / volume), MOST)
    return scaled(scale)
