"""Colours that the camera could not tell: brighter than its brightest.

Where ink or bed is clipped its level is not known, and half-way between ink and bed even less: an
overexposed bed makes dark beads narrower. A channel that is clipped in much of the picture is left
out; where the others do not tell either, nothing is told.
"""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.capture.exposure import CLIPPED

COMMON = 0.1  # share of the path from which a channel is left out
USED = 0.1  # share of the step from bed to ink that a channel tells, from which it counts
MOST_NOISE = 10.0  # that a level may lie below the brightest, and be clipped [grey levels]
LEFT_OUT_VARIANCE = 1e8  # makes a channel count for nothing [grey levels^2]


def left_out(bed: Array, ink: Array, spread: Array) -> Array:
    """Return what to add to the variance (3,) of each channel, so that clipped ones do not count.

    If all are clipped all of them stay: there is nothing better.

    Args:
        bed: (2, N, 3) colours of the bed on both sides.
        ink: (N, 3) colours of the ink; NaN = not known.
        spread: (3, 3) how colours vary within the bed.
    """
    common = clipped(bed, ink, spread).mean(axis=0) > COMMON
    return np.where(common & ~common.all(), LEFT_OUT_VARIANCE, 0.0)


def clipped(bed: Array, ink: Array, spread: Array) -> Flags:
    """Return which channels (N, 3) of bed (2, N, 3) or ink (N, 3) are clipped.

    What is clipped before the camera adds noise lies below the brightest by about that noise, see
    ``left_out``.
    """
    limit = CLIPPED + 1 - np.clip(np.sqrt(np.diag(spread)), 1.0, MOST_NOISE)
    return np.asarray((bed >= limit).any(axis=0) | (ink >= limit))


def clipped_where_used(bed: Array, ink: Array, spread: Array, weight: Array,
                       step: Array) -> Flags:
    """Return where (N,) a channel is clipped that tells ink from bed.

    Args:
        bed: (2, N, 3) colours of the bed on both sides.
        ink: (N, 3) colours of the ink; NaN = not known.
        spread: (3, 3) how colours vary within the bed.
        weight: (N, 3) of the channels.
        step: (N, 3) from bed to ink.
    """
    share = np.abs(weight * step)
    used = share > USED * share.sum(axis=1, keepdims=True)
    return np.asarray((clipped(bed, ink, spread) & used).any(axis=1))
