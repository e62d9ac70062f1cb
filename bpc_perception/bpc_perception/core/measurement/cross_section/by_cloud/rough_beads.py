"""About where beads lie in the cloud, and how wide they are: by where they are half as high."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array, Floats
from bpc_perception.core.filters import last_true, masked_median
from bpc_perception.core.measurement.cross_section.sections.sections import Sections

HALF_LEVEL = 0.5**0.5  # of half a width, where a parabola is half as high


def rough_beads(sections: Sections) -> tuple[Array, Array]:
    """Return middle and width (N,) of beads, steady along the path [m]; NaN where not known."""
    left, right = half_way_down(sections)
    width = sections.steady((left - right) / HALF_LEVEL)
    return sections.steady((left + right) / 2), width


def half_way_down(sections: Sections) -> tuple[Array, Array]:
    """Return where (N,) beads come down to half their height on the left and the right [m].

    Places to the left of the path; NaN where they do not.
    """
    height = np.where(sections.visible, sections.height, np.nan)
    central = height[:, np.abs(sections.offset) <= 2 * sections.pixel]
    ridge = sections.steady(masked_median(central, np.isfinite(central)))
    middle = sections.on_path
    left, right = (_first_below(sections.place[:, side], height[:, side], ridge / 2)
                   for side in (slice(middle, None), slice(middle, None, -1)))
    return left, right


def _first_below(place: Floats, height: Floats, level: Array) -> Array:
    """Return the first places (N,) in rows (N, K) at which heights fall to a level (N,).

    Between two points it is on the straight line; NaN = nowhere.
    """
    down = height < level[:, None]
    known = np.isfinite(height + place)
    inner = last_true((np.cumsum(down, axis=1) == 0) & known)
    outer = np.argmax(down & known, axis=1)
    row = np.arange(len(place))
    high, low = height[row, inner], height[row, outer]
    with np.errstate(invalid='ignore', divide='ignore'):
        share = np.clip((high - level) / (high - low), 0, 1)
    found = (inner >= 0) & down.any(axis=1)
    return np.where(found, (1 - share) * place[row, inner] + share * place[row, outer], np.nan)
