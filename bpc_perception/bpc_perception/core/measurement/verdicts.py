"""What is known of each sample, and where nothing is, why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Flags, Index
from bpc_perception.core.measurement.side_points import replaced
from bpc_perception.core.profile import Cause, CauseArray, Status, StatusArray

Condition = tuple[Flags, Status, Cause]  # (N,) where it holds, and what is known there


@dataclass(frozen=True)
class Verdicts:
    """What is known of N samples.

    Attributes:
        status: (N,) values of Status.
        cause: (N,) values of Cause: why there is no answer.
    """

    status: StatusArray
    cause: CauseArray

    @classmethod
    def all_of(cls, count: int, status: Status, cause: Cause = Cause.NONE) -> Verdicts:
        """Return the same for all of ``count`` samples."""
        return cls(np.full(count, status, np.uint8), np.full(count, cause, np.uint8))

    @classmethod
    def by_first(cls, conditions: Sequence[Condition], otherwise: Verdicts) -> Verdicts:
        """Return what the first condition that holds says of each; where none does, otherwise."""
        status, cause = otherwise.status.copy(), otherwise.cause.copy()
        for holds, its_status, its_cause in reversed(conditions):
            status[holds], cause[holds] = its_status, its_cause
        return cls(status, cause)

    def where(self, chosen: Flags, status: Status, cause: Cause = Cause.NONE) -> Verdicts:
        """Return them with others where chosen (N,)."""
        return Verdicts.by_first([(chosen, status, cause)], self)

    def of(self, index: Index) -> Verdicts:
        """Return those of an index (K,)."""
        return Verdicts(self.status[index], self.cause[index])

    def with_part(self, index: Index, part: Verdicts) -> Verdicts:
        """Return them with those of an index (K,) replaced by a part (K,)."""
        return Verdicts(replaced(self.status, index, part.status),
                        replaced(self.cause, index, part.cause))
