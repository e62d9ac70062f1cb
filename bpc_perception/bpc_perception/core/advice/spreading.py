"""Ink that widens after it was laid, as looking again shows.

A bead that spreads becomes wider on both sides, and holds as much ink as before. What it becomes
later says nothing of the rate: once spreading is noticed, advice goes by the width at which each
sample was seen first. All of these are of about one age: at most a period between captures.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.filters import places_of
from bpc_perception.core.profile import Status, ThicknessProfile

LEAST_WIDER = 0.03  # share of the width, that tells
LEAST_SAMPLES = 25  # seen again
ALIKE_M = 1e-3  # of path, along which errors are alike
SURE_SIGMAS = 3.0
ONE_SIDE = 0.25  # of what a bead widens, at least, on each side: else something had hidden one
# By which share of what the width grows an area may: of ink that was hidden, both grow alike.
MOST_MORE_INK = 0.5
LATEST_S = 60.0  # since ink was laid; the older it is, the slower it spreads
WIDTH, SIGMA, LEFT, RIGHT, AREA, SEEN, ALONG = range(7)  # of a sample
OF_WIDTH = {'thickness': WIDTH, 'sigma': SIGMA, 'left': LEFT, 'right': RIGHT}


class Spreading:
    """What the samples of one print were when they were seen first.

    Attributes:
        rate: by how much ink widens after it was laid, as a share of its width [1/s]; 0 = as far
            as is known it does not, NaN = too little was seen again.
        noticed: whether it ever did.
    """

    def __init__(self) -> None:
        self.rate = np.nan
        self.noticed = False
        self._stamps: dict[int, float] = {}  # of captures, since the start of the print [s]
        self._time: Array = np.empty(0)
        self._first: Array = np.empty((0, 7))  # of each sample; NaN where it was not seen

    def look(self, profile: ThicknessProfile) -> None:
        """Take in what a capture shows."""
        stamp = (profile.stamp_ns - profile.print_start_ns) * 1e-9
        self._stamps[profile.capture] = stamp
        now, before = self._measured(profile), self._known(profile.time)
        again = (now[:, SEEN] > before[:, SEEN]) & (profile.time > stamp - LATEST_S)
        if again.sum() >= LEAST_SAMPLES:
            self.rate = widening(before[again], now[again])
            self.noticed |= self.rate > 0
        self._time = profile.time
        self._first = np.where(np.isfinite(before[:, [SEEN]]), before, now)

    def as_laid(self, profile: ThicknessProfile) -> ThicknessProfile:
        """Return a profile (N samples) with the widths that were seen first, if ink spreads."""
        if not self.noticed:
            return profile
        first = self._known(profile.time)
        known = np.isfinite(first[:, SEEN]) & (profile.status == Status.MEASURED)
        widths: dict[str, Any] = {name: np.where(known, first[:, column], getattr(profile, name))
                                  for name, column in OF_WIDTH.items()}
        return replace(profile, **widths)

    def _known(self, time: Array) -> Array:
        """Return what samples at times (N,) were when they were seen first (N, 7)."""
        place = places_of(self._time, time)
        known = place >= 0
        first = np.full((len(time), 7), np.nan)
        first[known] = self._first[place[known]]
        return first

    def _measured(self, profile: ThicknessProfile) -> Array:
        """Return what is known of samples (N, 7) that were seen in captures known here."""
        captures, which = np.unique(profile.seen_in, return_inverse=True)
        at = np.array([self._stamps.get(number, np.nan) for number in captures.tolist()])[which]
        values = np.column_stack((
            profile.thickness, profile.sigma, profile.left, profile.right, profile.area, at,
            profile.arc_length))
        known = (profile.status == Status.MEASURED) & np.isfinite(at)
        return np.where(known[:, None], values, np.nan)


def widening(before: Array, now: Array) -> float:
    """Return by how much samples have widened, as a share of their width [1/s]; 0 = not for sure.

    Args:
        before: (K, 7) what they were when they were seen first.
        now: (K, 7) what they are.
    """
    wider = np.log(now[:, WIDTH] / before[:, WIDTH])
    middle = float(np.median(wider))
    scatter = 1.4826 * float(np.median(np.abs(wider - middle)))
    independent = len(np.unique(np.floor(now[:, ALONG] / ALIKE_M)))
    if not middle > max(LEAST_WIDER, SURE_SIGMAS * scatter / np.sqrt(independent)):
        return 0.0
    outwards = np.median(now - before, axis=0)[[LEFT, RIGHT]]
    if not outwards.min() > ONE_SIDE * outwards.sum():
        return 0.0
    with np.errstate(invalid='ignore', divide='ignore'):
        more = np.log(now[:, AREA] / before[:, AREA])
    known = np.isfinite(more)
    if known.any() and np.median(more[known]) > MOST_MORE_INK * np.median(wider[known]):
        return 0.0
    return float(np.median(wider / (now - before)[:, SEEN]))
