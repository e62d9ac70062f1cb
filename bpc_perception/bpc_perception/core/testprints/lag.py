"""How late ink comes and goes: against when the extruder is told.

Where ink begins and ends on a line is seen on the bed. When the nozzle passed there, and where it
was when the extruder began and ended to push, is in the path. What is told of one line by that is

    delay = lag + away / speed,

since the ink's end is round, and its edge lies somewhere below the nozzle: always about as far
away. Lines of several speeds tell both.

What the extruder is told is in its states, of which the first that differs counts: it was told
half a period before, more or less.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.profile import Cause, Status, ThicknessProfile
from bpc_perception.core.testprints.matching import MatchedPrint

INK = (Status.MEASURED, Status.JUNCTION)  # on a stroke
UNSEEN = (Status.NO_DATA, Status.OCCLUDED)
STATE_PERIOD_S = 0.02  # between states of the extruder, usually
HOLE = 3.0  # spacings, beyond which samples do not follow each other
LEAST_LINES = 3
LEAST_SPEED_RATIO = 1.3  # of the fastest to the slowest line, that tells lag from distance
UNTOLD_WIDTHS = 0.25  # by which ink may seem to end early or late, where speeds do not tell


@dataclass(frozen=True)
class Delay:
    """How much later than told ink came, or went, on one line.

    Attributes:
        time: [s]; NaN = not seen.
        sigma: 1-sigma uncertainty [s]; NaN alike.
        note: why it is not known; empty = it is.
    """

    time: float
    sigma: float
    note: str = ''

    @classmethod
    def unknown(cls, note: str) -> Delay:
        """Return a delay that is not known, and why."""
        return cls(np.nan, np.nan, note)


@dataclass(frozen=True)
class Lag:
    """What the delays of L lines tell.

    Attributes:
        time: lag of the ink [s]; NaN = not known.
        sigma: 1-sigma uncertainty [s].
        away: how far ink seems to begin or end behind where it does [m]; NaN = not told.
        lines: how many tell.
        note: why it is not known, else what has to be said beside it; empty = nothing.
    """

    time: float
    sigma: float
    away: float
    lines: int
    note: str = ''


def start_delay(matched: MatchedPrint, index: int, period: float = STATE_PERIOD_S) -> Delay:
    """Return how much later ink came on a planned stroke than the extruder was told.

    ``period`` is the time between states of the extruder [s].
    """
    return _delay(matched, index, 1, period)


def stop_delay(matched: MatchedPrint, index: int, period: float = STATE_PERIOD_S) -> Delay:
    """Return how much later ink ended on a planned stroke than the extruder was told."""
    return _delay(matched, index, -1, period)


def _delay(matched: MatchedPrint, index: int, way: int, period: float) -> Delay:
    """Return the delay of start (way 1) or stop (way -1) of a planned stroke.

    Samples are looked at from the inner end of the stroke outwards.
    """
    profile, plan = matched.profile, matched.test.plans[index]
    own = np.flatnonzero(matched.on(index))
    if not len(own):
        return Delay.unknown('the line is not printed')
    inner, outer = (own[-1], own[0]) if way == 1 else (own[0], own[-1])
    told = outer - way  # the neighbour on travel: between both the extruder switched
    beyond = _beyond(profile, outer, way, plan.lead_in if way == 1 else plan.run_out)
    if not len(beyond):
        return Delay.unknown('no way without ink is seen '
                             + ('before it' if way == 1 else 'behind it'))
    if not profile.extruder_known[[outer, told]].all():
        return Delay.unknown('when the extruder was told is not recorded')
    line = np.concatenate((np.arange(inner, outer - way, -way), beyond))
    status = profile.status[line]
    on_stroke = profile.stroke[line] > 0
    # Ink of which travel alone does not tell whose it is, is this line's: so it runs on.
    ooze = (status == Status.OOZE) | (profile.cause[line] == Cause.OVER_STROKE)
    inked = np.where(on_stroke, np.isin(status, INK), ooze)
    bare = np.where(on_stroke, status == Status.GAP, status == Status.BARE)
    if not inked.any():
        return Delay.unknown('no ink is seen on it')
    last = int(np.flatnonzero(inked)[-1])
    after = np.flatnonzero(bare[last:])
    if not len(after):
        return Delay.unknown('ink is seen to the end of the way ' + (
            'before it' if way == 1 else 'behind it'))
    first = last + int(after[0])
    if np.isin(status[last + 1:first], UNSEEN).any():
        return Delay.unknown('where ink begins is not seen' if way == 1 else
                             'where ink ends is not seen')
    edge, edge_sigma = _between(profile, line[last], line[first])
    switch, switch_sigma = _between(profile, told, outer)
    switch_sigma = float(np.hypot(switch_sigma, period / np.sqrt(12)))
    return Delay(edge - switch + period / 2, float(np.hypot(edge_sigma, switch_sigma)))


def _beyond(profile: ThicknessProfile, outer: int, way: int, length: float) -> Index:
    """Return the samples of travel beyond the end of a stroke, as far as the nozzle went alike."""
    arc, step = profile.arc_length, np.median(np.diff(profile.arc_length))
    found = []
    sample = outer - way
    while (0 <= sample < len(arc) and profile.stroke[sample] == 0
           and abs(arc[sample] - arc[sample + way]) <= HOLE * step
           and abs(arc[sample] - arc[outer]) <= length):
        found.append(sample)
        sample -= way
    return np.array(found, np.intp)


def _between(profile: ThicknessProfile, one: int, other: int) -> tuple[float, float]:
    """Return the time half-way between two samples, and how unsure it is [s]."""
    times = profile.time[[one, other]]
    return float(times.mean()), float(np.ptp(times)) / np.sqrt(12)


def lag_of(delays: Sequence[Delay], speeds: Array, width: float) -> Lag:
    """Return the lag that is common to lines, by their delays.

    Args:
        delays: of L lines.
        speeds: (L,) of the nozzle [m/s].
        width: usual one of the beads [m].
    """
    known = np.array([not np.isnan(delay.time) for delay in delays], bool)
    if not known.any():
        notes = sorted({delay.note for delay in delays}) or ['no line is printed']
        return Lag(np.nan, np.nan, np.nan, 0, notes[0])
    time = np.array([delay.time for delay in delays])[known]
    sigma = np.array([delay.sigma for delay in delays])[known]
    speed = np.asarray(speeds)[known]
    weight = 1 / sigma**2
    if len(time) < LEAST_LINES or speed.max() < LEAST_SPEED_RATIO * speed.min():
        mean = float(np.average(time, weights=weight))
        unsure = UNTOLD_WIDTHS * width / float(speed.mean())
        return Lag(mean, float(np.hypot(np.sqrt(1 / weight.sum()), np.nan_to_num(unsure))), np.nan,
                   len(time), 'lines of one speed do not tell it from how far ink seems to reach')
    matrix = np.stack((np.ones(len(time)), 1 / speed), axis=1)
    covariance = np.linalg.inv(matrix.T @ (weight[:, None] * matrix))
    solved = covariance @ matrix.T @ (weight * time)
    off = (time - matrix @ solved) / sigma
    # Lines differ by more than is known of each.
    scale = max(1.0, float(np.sum(off**2)) / (len(time) - 2))
    return Lag(float(solved[0]), float(np.sqrt(scale * covariance[0, 0])), float(solved[1]),
               len(time))
