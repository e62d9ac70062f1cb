"""The bead that an extruder with faults lays, as a deposit with gaps where it tears."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.ink.deposit import Deposit
from bpc_sim.ink.extrusion import Extrusion, THINNEST_BEAD_M


def laid_bead(commanded: Deposit, extrusion: Extrusion, step: float) -> Deposit:
    """Return the ink that an extrusion laid along the path of a commanded print.

    Args:
        commanded: path, and what it lies on.
        extrusion: as far as it has come.
        step: between the arc lengths at which gaps are looked for [m].
    """
    s = np.arange(0.0, commanded.curve.length + step, step)
    bare = np.concatenate(([False], extrusion.width(s) == 0, [False])).astype(np.int8)
    starts, ends = np.flatnonzero(np.diff(bare) == 1), np.flatnonzero(np.diff(bare) == -1) - 1
    # Gaps extend by half a step to either side; a print that has not begun is one gap.
    gaps = np.column_stack((s[starts] - step / 2, s[ends] + step / 2))

    def profile(s: Array) -> Array:
        s = np.asarray(s)
        return np.maximum(extrusion.width(s.ravel()).reshape(s.shape), THINNEST_BEAD_M)

    return replace(commanded, profile=profile, gaps=gaps,
                   height_ratio=extrusion.behaviour.height_ratio)
