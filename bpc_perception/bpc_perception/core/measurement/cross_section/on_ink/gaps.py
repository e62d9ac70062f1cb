"""Gaps in strokes on ink: colour does not tell them, the cloud does.

Where no ink was laid, the cloud is no higher in the middle of the bead than what lay there before,
or lies far below, as in a pore.
"""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.filters import runs, window_sums, windows_around
from bpc_perception.core.measurement.cross_section.on_ink.bead import Beads, POOLED_M
from bpc_perception.core.measurement.cross_section.on_ink.widths import LEAST_TOP
from bpc_perception.core.measurement.cross_section.sections.sections import Sections

CENTRAL = 0.6  # of the width of a bead
# Of the points there so many have to be seen, and so many at most may be ink's, or noise.
LEAST_SEEN, MOST_HIGH = 0.5, 0.1
LEAST_BEAD_M = 1.5e-4  # a bead that seems to be lower hardly differs from none
LEAST_LENGTH = 1.5  # of a gap, in widths of the bead


def missing_ink(sections: Sections, beads: Beads, sure: Flags, before: Array) -> Flags:
    """Return where (N,) a stroke on ink has a gap.

    Args:
        sections: N sections.
        beads: what the cloud says of them.
        sure: (N,) which of them are beads, whose width is known.
        before: (N,) how high the ink below is above the feet of the sections [m]; -inf = none,
            NaN = not known.
    """
    top, width, middle = (float(np.median(values[sure])) if sure.any() else np.nan
                          for values in (beads.top, beads.width, beads.middle))
    floor = np.fmax(before, 0.0)
    if not top - np.median(floor) >= LEAST_BEAD_M:
        return np.zeros(len(sure), bool)
    central = np.abs(sections.offset - middle) <= CENTRAL * width / 2
    height = np.where(sections.visible[:, central], sections.height[:, central], np.nan)
    ink = height > (floor + LEAST_TOP * (top - floor))[:, None]
    around = windows_around(sections.piece, round(POOLED_M / sections.spacing))
    seen, high = window_sums(
        np.stack((np.isfinite(height).sum(axis=1), ink.sum(axis=1)), axis=1), around).T
    asked = (around[1] - around[0]) * central.sum()
    bare = (seen >= LEAST_SEEN * asked) & (high <= MOST_HIGH * seen)
    first, end = runs(2 * sections.piece + bare)
    # All of the window around a place is bare: the gap goes on so far beyond the last of them.
    length = (end - first) * sections.spacing + 2 * POOLED_M
    return np.asarray(bare & (length >= LEAST_LENGTH * width))
