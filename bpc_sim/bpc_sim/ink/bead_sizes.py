"""The true height and cross-section of beads above what lay there before."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.ink.deposit import Deposit

# Across a bead: places, and their weights. So many, because the surface below has edges.
U, WEIGHT = np.polynomial.legendre.leggauss(101)
MIDDLE = len(U) // 2


def sizes_above(bead: Deposit, below: Sequence[Deposit], s: Array) -> tuple[Array, Array]:
    """Return height (N,) [m] and area (N,) [m^2] of a bead at arc lengths s (N,) [m].

    Its ink counts from its own foot on, or from what lies below, whichever is higher.

    Args:
        bead: the bead.
        below: the ink that lay there before.
        s: arc lengths.
    """
    width, foot = bead.width(s), bead.base(s)
    places = bead.curve.points(s)[:, None] + (
        U[:, None] * (width[:, None] / 2 * bead.curve.normals(s))[:, None])
    floor = np.repeat(foot[:, None], len(U), axis=1)
    for ink in below:
        heights = ink.height(places.reshape(-1, 2)).reshape(floor.shape)
        floor = np.maximum(floor, heights)
    above = foot[:, None] + bead.height_ratio * width[:, None] * (1 - U**2) - floor
    return above[:, MIDDLE], width / 2 * (np.maximum(above, 0.0) @ WEIGHT)
