"""Iterative learning: what the layers before did wrong is corrected before it happens again.

The law is iterative learning control by inversion of a model [Bristow, Tharayil and Alleyne, IEEE
Control Systems 26(3), 2006, sections "plant inversion" and "Q-filter"]:

    z_i(s) = log arrived_i(s) - 2 log w_i(s)      what has to arrive for a width, from layer i
    u_next = command whose arrival, behind lag and dead time, is w_wanted^2 exp(Q z)

``Q`` is ``repeating``. Only the command that was recorded enters: whether advice and schedule were
followed does not matter. The gain does not enter at all: a wrong one cannot make it diverge. A lag
that is assumed too long by less than twice, or a dead time off by 0.1 s at the 0.5 mm that ``Q``
lets pass, leaves |1 - P/P_model| below 1, so that the error shrinks from layer to layer.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.learning.delay import Delay, fit_delay, needed
from bpc_perception.core.learning.layer_record import LayerRecord, TIME_STEP_S
from bpc_perception.core.learning.rate_schedule import RateSchedule
from bpc_perception.core.learning.repeating import repeating, STEP_M

LAYERS_KEPT = 5
LEAST_COVERAGE = 0.5
LEAST_SPEED_M_PER_S = 1e-6
FADING = 0.5  # of the time until ink is gone, it is half as wide
LONGEST_SHIFT_S = 1.0  # of a switch of the extruder
# Behind a lag nothing is followed that is shorter than this part of it: its command would swing.
LAG_SHARE = 0.25


class Learner:
    """Learns from one layer after the other of the same path.

    Args:
        limits: on the factors.
        gain: logarithm of w^2 over the volume per length that the first was set up with.
    """

    def __init__(self, limits: AdviceConfig, gain: float) -> None:
        self._gain = gain
        self._limits = limits
        self._records: list[LayerRecord] = []
        self._first: LayerRecord | None = None  # learned from: it has the path as it is meant
        self._switches = np.zeros((0, 2))  # advance and retreat (L, 2) of each layer kept [s]

    def take(self, record: LayerRecord, followed: RateSchedule | None = None) -> bool:
        """Learn from a layer; return whether it served.

        Args:
            record: of the layer.
            followed: the schedule that was published for it; None = there was none.
        """
        if record.coverage < LEAST_COVERAGE or not record.usable.any():
            return False
        self._first = self._first or record
        aligned = record.aligned(self._first)
        if aligned is None:
            return False
        switches = (followed.advance, followed.retreat) if followed else (0.0, 0.0)
        stood = record.rate[0] > 0
        self._records.append(replace(aligned, lead=switches[0] if stood else 0.0))
        self._switches = np.vstack((self._switches, switches))[-LAYERS_KEPT:]
        del self._records[:-LAYERS_KEPT]
        return True

    @property
    def based_on(self) -> tuple[tuple[str, int], ...]:
        """Print and number of each layer learned from, the newest last."""
        return tuple((one.print_id, one.layer) for one in self._records)

    @property
    def end(self) -> float:
        """Place of the last ink of the first layer learned from [m]."""
        assert self._first is not None
        return float(self._first.place[self._first.strokes[-1, 1] - 1])

    def points(self, place: Array) -> Array:
        """Return where places (K,) were in the newest layer learned from, (K, 3) [m]."""
        newest = self._records[-1]
        return np.column_stack([np.interp(place, newest.place, axis)
                                for axis in newest.points.T])

    def schedule(self) -> RateSchedule | None:
        """Return the factors for the next layer of this path; None = nothing is learned yet."""
        if self._first is None:
            return None
        records, first = self._records, self._first
        delay = fit_delay(records)
        place = np.arange(0.0, first.place[-1] + STEP_M, STEP_M)
        curves = np.array([_at(place, one, needed(one, delay)) for one in records])
        found = repeating(curves, -self._gain)
        begins, ends = (first.place[first.strokes[:, 0]], first.place[first.strokes[:, 1] - 1])
        strokes = np.column_stack((begins, ends))
        newest = records[-1]
        before = self._switches[-1]
        advance = _switch(before[0], newest.late_begins(strokes), 1.0)
        retreat = _switch(before[1], newest.late_ends(strokes), FADING)
        command = self._command(first, place, found.value, delay, advance, retreat)
        volume = np.interp(place, first.place, _filled(
            np.interp(first.time, first.clock, command)
            / np.maximum(first.speed, LEAST_SPEED_M_PER_S), first.rate > 0))
        factor = np.clip(volume / self._reference, self._limits.minimum_scale,
                         self._limits.maximum_scale)
        return RateSchedule(place, factor, found.sigma, found.level_sigma,
                            factor * self._reference, self._reference, advance, retreat,
                            len(records))

    @property
    def _reference(self) -> float:
        """Volume per length that the first layer was set up with, where it begins."""
        assert self._first is not None
        wanted = self._first.wanted[self._first.strokes[0, 0]]
        return float(np.exp(-self._gain) * wanted**2)

    def _command(self, first: LayerRecord, place: Array, value: Array, delay: Delay,
                 advance: float, retreat: float) -> Array:
        """Return the command (K,) at the times of the first layer's clock.

        The advance is more than the dead time where a lag is to be filled before the stroke, and
        the retreat where what a lag holds back is to end with it.
        """
        clock = first.clock
        speed = np.interp(clock, first.time, np.maximum(first.speed, LEAST_SPEED_M_PER_S))
        needed_now = np.interp(np.interp(clock, first.time, first.place), place, value)
        area = 2 * np.log(np.interp(clock, first.time, first.wanted))
        smooth = _slower(needed_now + area, delay.lag)
        nominal = self._reference * speed
        most = self._limits.maximum_scale * nominal
        pushing = first.command > 0
        wanted = np.where(pushing, np.exp(smooth) * speed, 0.0)
        early = round(max(advance - delay.dead_time, 0.0) / TIME_STEP_S)
        late = round(max(retreat - delay.dead_time, 0.0) / TIME_STEP_S)
        least = np.where(_moved_ends(pushing, 0, -late),
                         self._limits.minimum_scale * nominal, 0.0)
        filling = _moved_ends(pushing, early, 0) & ~pushing
        return delay.command_for(np.where(filling, most, wanted), least,
                                 np.where(_moved_ends(pushing, early, -late), most, 0.0), early)


def _filled(values: Array, stroke: Flags) -> Array:
    """Return values (N,) without zeros: those before in a stroke, and those behind on travel."""
    index, pushed = np.arange(len(values)), np.flatnonzero(values > 0)
    if not len(pushed):
        return values
    behind = np.searchsorted(pushed, index)
    last = len(pushed) - 1
    before = pushed[np.clip(behind - 1, 0, last)]
    return np.where(values > 0, values,
                    values[np.where(stroke, before, pushed[np.clip(behind, 0, last)])])


def _moved_ends(flags: Flags, earlier: int, later: int) -> Flags:
    """Return flags (K,) whose runs begin so many steps earlier, and end so many later."""
    moved = flags.copy()
    for _ in range(earlier):
        moved[:-1] |= moved[1:]
    for _ in range(-later):
        moved[:-1] &= moved[1:]
    return moved


def _slower(value: Array, lag: float) -> Array:
    """Return values (K,) a time step apart, without what is too fast behind a lag [s]."""
    half = round(LAG_SHARE * lag / TIME_STEP_S / 2)
    if half == 0:
        return value
    padded = np.pad(value, half, mode='edge')
    return np.convolve(padded, np.full(2 * half + 1, 1 / (2 * half + 1)), 'valid')


def _at(place: Array, record: LayerRecord, value: Array) -> Array:
    """Return the mean of a record's values (N,) around each place (K,); NaN = none is known."""
    known = np.isfinite(value)
    cell = np.round(record.place[known] / STEP_M).astype(int)
    inside = (cell >= 0) & (cell < len(place))
    count = np.bincount(cell[inside], minlength=len(place))
    total = np.bincount(cell[inside], value[known][inside], minlength=len(place))
    return np.divide(total, count, out=np.full(len(place), np.nan), where=count > 0)


def _switch(before: float, late: Array, share: float) -> float:
    """Return how early to switch [s].

    Args:
        before: how early it was.
        late: (S,) how late ink came, or ended, all the same; NaN = not seen.
        share: of the whole delay, by which to be early.
    """
    known = late[np.isfinite(late)]
    if not len(known):
        return before
    return float(np.clip(share * (before + float(np.median(known))), 0.0, LONGEST_SHIFT_S))
