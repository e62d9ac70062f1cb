"""Where beads on ink break off in the cloud."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.filters import last_true
from bpc_perception.core.measurement.cross_section.on_ink.below import Beneath
from bpc_perception.core.measurement.cross_section.on_ink.known import mean_around
from bpc_perception.core.measurement.cross_section.sections.sections import Sections

CLIFF_SHARE = 0.7  # of a layer that the cloud goes down; a bead may hang down by the rest
CROSSING_MARGIN_PX = 3.0  # along the path, beside a strand below


def breaks_off(sections: Sections, goes_on: Flags, beneath: Beneath) -> tuple[Array, Array]:
    """Return how far (N,) to the left and to the right beads break off in the cloud [m].

    There the cloud goes down by most of a layer, from one of its points to the next. NaN = it does
    not, or a strand below goes on there (N, M).
    """
    level = -CLIFF_SHARE * beneath.layer_height
    down, up = sections.height < level, sections.height >= level
    middle = sections.on_path
    along = 2 * round(CROSSING_MARGIN_PX * sections.pixel / sections.spacing) + 1
    found = []
    for side in (slice(middle, None), slice(middle, None, -1)):
        before = np.cumsum(down[:, side], axis=1) == 0
        last, first = last_true(before & up[:, side]), before.sum(axis=1)
        crossed = maximum_filter1d(goes_on[:, side].any(axis=1), along)
        place = np.where((last >= 0) & (first < before.shape[1]) & ~crossed,
                         (last + first) / 2, np.nan)
        found.append(mean_around(place * (sections.offset[1] - sections.offset[0]), sections))
    return found[0], found[1]
