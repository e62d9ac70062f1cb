"""Rules that tell a drift from chance: tests 1 and 2 of Nelson.

[L. S. Nelson, The Shewhart control chart - tests for special causes, J. Quality Technology 16
(1984) 237; NIST/SEMATECH e-Handbook 6.3.2 has them after Western Electric, with 8 in a row]

His test 3, six in a row that rise or fall, is left out: it finds a drift at most half a print
earlier, and a third of all false alarms would be its own. [R. B. Davis, W. H. Woodall,
Performance of the control chart trend rule under linear shift, J. Quality Technology 20 (1988)]
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.control.individuals import ControlLimits, LIMIT_SIGMAS
from bpc_perception.core.filters import runs

SIDE_COUNT = 9  # in a row on one side of the centre: by chance at one place in 256


class Rule(Enum):
    """What is hardly by chance; the value says it in words."""

    ABOVE = 'above the upper control limit'
    BELOW = 'below the lower control limit'
    HIGH_SIDE = f'in a row of {SIDE_COUNT} or more above the centre'
    LOW_SIDE = f'in a row of {SIDE_COUNT} or more below the centre'


@dataclass(frozen=True)
class Alarm:
    """Prints that meet a rule.

    Attributes:
        rule: which.
        start, end: first print, and the one behind the last, as positions in the chart.
    """

    rule: Rule
    start: int
    end: int


def find_alarms(values: Array, limits: ControlLimits) -> list[Alarm]:
    """Return where values (N,) in the order of time meet a rule, in order.

    A print whose value is not known (NaN) neither continues nor interrupts a run. Without limits
    there are no alarms.
    """
    place = np.flatnonzero(np.isfinite(values))
    if limits.reason or not len(place):
        return []
    off = (values[place] - limits.centre) / limits.sigma
    found = (alarm for rule, met, fewest in (
        (Rule.ABOVE, off > LIMIT_SIGMAS, 1), (Rule.BELOW, off < -LIMIT_SIGMAS, 1),
        (Rule.HIGH_SIDE, off > 0, SIDE_COUNT), (Rule.LOW_SIDE, off < 0, SIDE_COUNT))
        for alarm in _alarms(rule, met, fewest))
    return sorted((Alarm(each.rule, int(place[each.start]), int(place[each.end - 1]) + 1)
                   for each in found), key=lambda alarm: alarm.start)


def _alarms(rule: Rule, met: Flags, fewest: int) -> list[Alarm]:
    """Return the runs of so many or more in which a condition (N,) is met."""
    first, end = runs(met.astype(np.intp))
    long = np.flatnonzero(met & (end - first >= fewest) & (first == np.arange(len(met))))
    return [Alarm(rule, int(first[start]), int(end[start])) for start in long]
