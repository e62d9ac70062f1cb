"""The strokes of a measured print: where ink was commanded, and where it began and ended."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index

# Ink may come so much later than it is commanded: what that explains is no gap. It may stop as
# much earlier or later, but not farther away: a fast nozzle draws it to a string, which is ooze.
ALLOWED_LAG_S = 0.5
ALLOWED_STOP_M = 0.002


@dataclass(frozen=True)
class Strokes:
    """S strokes in the order in which they were laid.

    Attributes:
        number: (S,) from 1.
        commanded: (S, 2) arc lengths between which ink was commanded [m].
        ink: (S, 2) arc lengths at which ink began and ended [m]; NaN = not seen.
    """

    number: Index
    commanded: Array
    ink: Array

    def __len__(self) -> int:
        return len(self.number)

    @property
    def lag(self) -> Array:
        """How far (S, 2) ink began and ended behind its command along the path [m]."""
        return self.ink - self.commanded


@dataclass(frozen=True)
class StrokeSamples:
    """What is known of N samples, as far as strokes are concerned.

    Attributes:
        stroke: (N,) number of the stroke; 0 = travel.
        arc_length: (N,) [m].
        time: (N,) when the nozzle passed [s].
        inked: (N,) whether ink is seen on a stroke.
        bare: (N,) whether bed is seen where ink was commanded.
        ooze: (N,) whether ink is seen on travel.
        doubtful: (N,) whether something is seen that is neither surely.
        captured: when they were seen [s].
    """

    stroke: Index
    arc_length: Array
    time: Array
    inked: Flags
    bare: Flags
    ooze: Flags
    doubtful: Flags
    captured: float

    def find(self) -> Strokes:
        """Find where ink began and ended in each stroke."""
        laid = np.flatnonzero(self.stroke > 0)
        if not len(laid):
            return Strokes(laid, np.empty((0, 2)), np.empty((0, 2)))
        number = self.stroke[laid]
        begins = np.flatnonzero(np.diff(number, prepend=0))
        ends = np.append(begins[1:], len(laid)) - 1
        group = np.cumsum(np.diff(number, prepend=0) != 0) - 1
        arc, count = self.arc_length, len(laid)
        inked, bare = self.inked[laid], self.bare[laid]
        hidden = ~(inked | bare | self.doubtful[laid])
        place = np.arange(count)

        def first(flags: Flags) -> Index:
            return np.minimum.reduceat(np.where(flags, place, count), begins)

        def last(flags: Flags) -> Index:
            return np.maximum.reduceat(np.where(flags, place, -1), begins)

        first_ink, last_ink = first(inked), last(inked)
        bare_before = last(bare & (place < first_ink[group]))
        bare_after = first(bare & (place > last_ink[group]))
        known = (first_ink < count)[:, None] & np.stack(
            (first(hidden) > first_ink, last(hidden) < last_ink), axis=1)
        run_on = laid[ends] + self._run_on(laid[ends])
        commanded = np.stack((arc[laid[begins]], arc[laid[ends]]), axis=1)
        ink = np.stack((
            np.where(bare_before >= 0, _between(arc[laid], bare_before, first_ink),
                     commanded[:, 0]),
            np.where(bare_after < count, _between(arc[laid], last_ink, bare_after),
                     arc[run_on])), axis=1)
        return Strokes(number[begins], commanded, np.where(known, ink, np.nan))

    def late(self) -> Flags:
        """Return where (N,) bed is bare since the ink of a stroke had not come yet."""
        start = np.flatnonzero((self.stroke > 0) & (np.diff(self.stroke, prepend=0) != 0))
        late = np.zeros(len(self.stroke), bool)
        # From the start of the stroke to the first sample that is anything else.
        other = np.append(np.flatnonzero(~self.bare | (self.stroke == 0)), len(self.stroke))
        end = other[np.searchsorted(other, start)]
        for one, two in zip(start, end, strict=True):
            lasted = self.time[max(two - 1, one)] - self.time[one]
            # In a stroke that ended without ink it is missing.
            ended = two < len(late) and self.stroke[two] != self.stroke[one]
            late[one:two] = lasted <= ALLOWED_LAG_S and not ended
        return late

    def early(self) -> Flags:
        """Return where (N,) bed is bare since ink had stopped already, or was still to come."""
        last = self._lasts
        early = np.zeros(len(self.stroke), bool)
        # From behind the last sample of the stroke that is anything else.
        other = np.append(-1, np.flatnonzero(~self.bare | (self.stroke == 0)))
        before = other[np.searchsorted(other, last, side='right') - 1]
        for one, two in zip(before + 1, last + 1, strict=True):
            # In a stroke without any ink it is missing.
            inked = one > 0 and self.stroke[one - 1] == self.stroke[two - 1]
            early[one:two] = inked and one < two and (
                bool(self._is_short(one, two - 1))
                # The camera may have looked before, or the ink come later.
                or self.captured - self.time[one] <= ALLOWED_LAG_S)
        return early

    def running_on(self) -> Flags:
        """Return where (N,) ink is seen on travel since that of a stroke had not stopped yet."""
        last = self._lasts
        on = np.zeros(len(self.stroke), bool)
        for index, count in zip(last, self._run_on(last), strict=True):
            on[index + 1:index + 1 + count] = True
        return on & self.ooze

    @cached_property
    def _lasts(self) -> Index:
        """The last sample (S,) of each stroke."""
        return np.flatnonzero((self.stroke > 0) & (np.diff(self.stroke, append=0) != 0))

    def _run_on(self, last: Index) -> Index:
        """Return for how many samples (S,) ink goes on behind the last ones of strokes (S,)."""
        unsure = (self.stroke == 0) & ~self.ooze & self.doubtful
        other = np.append(np.flatnonzero((self.stroke > 0) | ~(self.ooze | unsure)),
                          len(self.stroke))
        end = other[np.searchsorted(other, last + 1)]
        # What is doubtful at its end does not count.
        inked = np.maximum.accumulate(np.where(self.ooze, np.arange(len(self.ooze)), -1))
        count = np.maximum(inked[end - 1] - last, 0)
        place = np.minimum(last + count, len(self.time) - 1)
        return np.where(self._is_short(last, place), count, 0)

    def _is_short(self, start: Index, end: Index) -> Flags:
        """Return whether the way between two samples each (S,) is what a stop explains."""
        short: Flags = ((self.time[end] - self.time[start] <= ALLOWED_LAG_S)
                        & (self.arc_length[end] - self.arc_length[start] <= ALLOWED_STOP_M))
        return short


def _between(arc: Array, one: Index, other: Index) -> Array:
    """Return the arc lengths (S,) half-way between samples, where both indices are in range."""
    last = len(arc) - 1
    return np.asarray((arc[np.clip(one, 0, last)] + arc[np.clip(other, 0, last)]) / 2)
