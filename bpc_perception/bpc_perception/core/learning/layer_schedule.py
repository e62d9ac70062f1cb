"""The schedule of one layer, as it is told to the print controller."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.learning.rate_schedule import RateSchedule


class ScheduleReason(IntEnum):
    """Why the schedule is as it is; the numbers are those of RateSchedule.msg."""

    LEARNED = 0
    NOTHING_LEARNED = 1
    NOT_RECORDED = 2
    NOT_ENOUGH_SEEN = 3
    FAULTS = 4
    OTHER_PATH = 5


@dataclass(frozen=True, eq=False)
class LayerSchedule:
    """Factors for a layer, or why there are none.

    Attributes:
        stamp_ns: of the capture after which it was made [ns].
        print_id: of the print that it is for; empty = of the next.
        layer: number of the layer that it is for, from 0.
        reason: why it is as it is.
        schedule: the factors; None = there are none.
        points: (K, 3) where the places of the factors were in the newest layer that was learned
            from, in the base frame [m].
        based_on: the layers learned from, as print and number of the layer, the newest last.
    """

    stamp_ns: int
    print_id: str
    layer: int
    reason: ScheduleReason
    schedule: RateSchedule | None = None
    points: Array = field(default_factory=lambda: np.empty((0, 3)))
    based_on: tuple[tuple[str, int], ...] = ()

    @classmethod
    def none(cls, stamp_ns: int, print_id: str = '', layer: int = 0,
             reason: ScheduleReason = ScheduleReason.NOTHING_LEARNED) -> LayerSchedule:
        """Return that from a time on [ns] there is no schedule."""
        return cls(stamp_ns, print_id, layer, reason)

    @property
    def valid(self) -> bool:
        """Whether the factors may be applied."""
        return self.schedule is not None
