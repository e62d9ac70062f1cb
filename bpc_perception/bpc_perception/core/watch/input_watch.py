"""Whether an input goes on, told from when its messages came."""

from __future__ import annotations

from collections import deque
from enum import IntEnum

from bpc_perception.core.config import WatchConfig


class Level(IntEnum):
    """As diagnostic_msgs/DiagnosticStatus has them; STALE = never heard of."""

    OK, WARN, ERROR, STALE = range(4)


class InputWatch:
    """Silence of one input against thresholds; times in seconds of a steady clock.

    A stream is due all the time. What comes at a pace of its own is due when the longest of its
    last pauses is over, and never while these differ by more than ``REGULAR``: whoever captures
    by hand is not late.
    """

    PAUSES, REGULAR = 3, 2.0

    def __init__(self, config: WatchConfig, paced: bool = False) -> None:
        self._config = config
        self._paced = paced
        self._last: float | None = None
        self._pauses: deque[float] = deque(maxlen=self.PAUSES)

    def heard(self, now: float) -> None:
        """Take note of a message."""
        if self._last is not None and self._paced:
            self._pauses.append(now - self._last)
        self._last = now

    def age(self, now: float) -> float | None:
        """Of the newest message; None before the first."""
        return None if self._last is None else now - self._last

    def level(self, now: float) -> Level:
        """How bad its silence is by now."""
        if self._config.warn_after == 0:
            return Level.OK
        if self._last is None:
            return Level.OK if self._paced else Level.STALE
        overdue = now - self._last - self._pace()
        if self._config.error_after and overdue > self._config.error_after:
            return Level.ERROR
        return Level.WARN if overdue > self._config.warn_after else Level.OK

    def _pace(self) -> float:
        if not self._paced:
            return 0.0
        regular = (len(self._pauses) == self.PAUSES
                   and max(self._pauses) <= self.REGULAR * min(self._pauses))
        return max(self._pauses) if regular else float('inf')
