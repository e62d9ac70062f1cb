"""How far from the path edges are looked for: farther where beads turn out to be wider."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.samples import Samples
from bpc_perception.core.measurement.track import Track
from bpc_perception.core.measurement.view import View
from bpc_perception.core.profile import Cause, Status

# A bead that fills the reach has no edge, or leaves no bed to be told from.
TOO_NEAR = Cause.NO_EDGE, Cause.LOW_CONTRAST, Cause.PARTLY_INK
LEAST_LOST = 0.2  # share of the samples that are lost so, from which it is looked farther
LEAST_GAIN = 0.1  # share of the samples that are told besides, for which that is worth it
GROWTH = 2.0  # from one reach to the next, and of the print until they are tried again
LONGEST_M = 0.05  # what is wider is no bead
MOST_UNLIKE = 0.25  # share of the width by which that of a bead varies, or differs, at most
# Square of the width per cross-section; 17 where ink meets the bed at 20 degrees.
MOST_FLAT = 40.0
WIDEST_M = 0.015  # of a bead of which no cross-section was commanded that is known


@dataclass(frozen=True)
class Reach:
    """What was found out about the reach of a print.

    Attributes:
        length: how far edges are looked for [m]; 0 = as configured.
        tried_at: number of path points when that was chosen; 0 = never.
    """

    length: float = 0.0
    tried_at: int = 0

    def applied(self, config: ThicknessConfig) -> ThicknessConfig:
        """Return how to measure with this reach, or the configured one if that is farther."""
        if self.length <= config.cross_section.reach:
            return config
        return replace(config, cross_section=replace(config.cross_section, reach=self.length))

    def may_be_too_near(self, samples: Samples) -> bool:
        """Return whether a farther reach may tell more, and was not tried on this print yet."""
        return (len(samples.status) >= GROWTH * self.tried_at
                and bool(lost(samples).mean() > LEAST_LOST))


def lost(samples: Samples) -> Flags:
    """Return which samples (N,) may have no answer because the reach is too near."""
    return np.isin(samples.verdicts.cause, TOO_NEAR)


def told(samples: Samples) -> Flags:
    """Return which samples (N,) have a width."""
    return np.asarray(samples.status == Status.MEASURED)


def follows_path(found: Samples, before: Samples, track: Track) -> bool:
    """Return whether widths found with a farther reach are those of a bead.

    A plate or a slide below a print that is hardly seen has edges on both sides, too. A bead is
    about even and lies on its path, its width is that told with a nearer reach, and it is no film.

    Args:
        found: N samples.
        before: the same with a nearer reach.
        track: the N points.
    """
    new = told(found)
    if not new.any():
        return False
    left, right, width = found.sides.left_distance, found.sides.right_distance, found.sides.width
    usual = float(np.median(width[new]))
    quartiles = np.quantile(width[new], (0.25, 0.75))
    aside = float(np.median(np.abs(left - right)[new]))
    both = new & told(before)
    nearer = before.sides.width[both] / width[both]
    same = not both.any() or bool(np.median(nearer) > 1 - MOST_UNLIKE)
    area = commanded_area(track)
    widest = WIDEST_M if np.isnan(area) else np.sqrt(MOST_FLAT * area)
    even = np.ptp(quartiles) <= MOST_UNLIKE * usual and aside <= MOST_UNLIKE * usual
    return bool(same and even and usual <= widest)


def commanded_area(track: Track) -> float:
    """Return the usual volume of ink that was commanded per length of path [m^2].

    NaN = not known.
    """
    pushed = track.flow_rate[track.flow_rate > 0]
    if not len(pushed):
        return float('nan')
    going_on = np.diff(track.piece) == 0
    speed = np.diff(track.along)[going_on] / np.diff(track.time)[going_on]
    return float(np.median(pushed) / np.median(speed)) if len(speed) else float('nan')


def farther_ones(view: View, points: Array, config: ThicknessConfig) -> Iterator[float]:
    """Yield reaches that are farther than the configured one, as far as the image goes [m]."""
    camera = view.capture.camera
    longest = min(LONGEST_M, view.pixel_size(points) * max(camera.width, camera.height) / 2)
    reach = config.cross_section.reach * GROWTH
    while reach <= longest:
        yield reach
        reach *= GROWTH
