"""Widths that contradict themselves: something seems to hide ink that is there.

Ink that was laid does not become narrower. Where less ink arrives, both edges of the bead come in.
Where one comes in alone, or what was wider before is narrow now, something lies over the ink, or
a smear is on the lens. What is hidden is not lacking.
"""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.filters import places_of
from bpc_perception.core.profile import Status, ThicknessProfile

NARROWER = 0.9  # share of the width that was measured before
THIN = 0.92  # share of the usual width
# Shift of a bead's middle, as a share of what it is thinner: half, if one edge comes in alone.
ONE_SIDED = 0.3
LEAST_NARROWER, LEAST_THIN = 0.1, 0.2  # share of what is measured
LEAST_USUAL = 20  # samples that tell what is usual
WIDE = 0.75  # quantile of the width from which on samples do, where all are looked at


class Contradictions:
    """What was measured of the samples of one print before."""

    def __init__(self) -> None:
        self._time: Array = np.empty(0)
        self._width: Array = np.empty(0)  # the greatest that was measured of each sample

    def found(self, profile: ThicknessProfile, extent: tuple[float, float]) -> bool:
        """Return whether widths between two arc lengths [m] contradict what is known besides."""
        measured = profile.status == Status.MEASURED
        arc = profile.arc_length
        inside = measured & (arc >= extent[0]) & (arc <= extent[1])
        narrower = self._narrower(profile, measured)
        if not inside.any():
            return False
        hidden = narrower[inside].mean() > LEAST_NARROWER
        return bool(hidden or _one_sided(profile, inside, measured & ~inside & ~narrower))

    def _narrower(self, profile: ThicknessProfile, measured: Flags) -> Flags:
        """Return which samples (N,) were wider before, and remember what they are now."""
        before = np.full(len(profile), np.nan)
        place = places_of(self._time, profile.time)
        known = place >= 0
        before[known] = self._width[place[known]]
        width = np.where(measured, profile.thickness, np.nan)
        self._time, self._width = profile.time, np.fmax(before, width)
        return np.asarray(width < NARROWER * before)


def _one_sided(profile: ThicknessProfile, inside: Flags, others: Flags) -> bool:
    """Return whether beads are thin because one edge alone comes in.

    Args:
        profile: N samples.
        inside: (N,) those that are looked at.
        others: (N,) those that tell what is usual; where they are few, the widest inside do.
    """
    width, middle = profile.thickness, (profile.left - profile.right) / 2
    if others.sum() < LEAST_USUAL:
        others = inside & (width >= np.quantile(width[inside], WIDE))
    if others.sum() < LEAST_USUAL:
        return False
    usual = np.median(width[others])
    thin = inside & (width < THIN * usual)
    if not thin.sum() > LEAST_THIN * inside.sum():
        return False
    shift = np.abs(np.median(middle[thin]) - np.median(middle[others]))
    return bool(shift > ONE_SIDED * (usual - np.median(width[thin])))
