"""Whether an input still arrives, judged from when its messages came."""

from __future__ import annotations

from collections import deque
from enum import IntEnum

from bpc_perception.core.config import WatchConfig


class Level(IntEnum):
    """The levels of diagnostic_msgs/DiagnosticStatus; STALE = nothing came yet."""

    OK, WARN, ERROR, STALE = range(4)


class InputWatch:
    """Compares the silence of one input with thresholds; all times in seconds of a steady clock.

    A stream is due all the time. An input with a pace of its own is due when the longest of its
    last pauses is over. It is never due while these differ by more than a factor of
    ``LARGEST_PAUSE_RATIO``: somebody who captures by hand is not late.
    """

    PAUSES_KEPT = 3
    LARGEST_PAUSE_RATIO = 2.0

    def __init__(self, config: WatchConfig, paced: bool = False) -> None:
        """Watch a stream, or an input with a pace of its own (``paced``)."""
        self._config = config
        self._paced = paced
        self._last: float | None = None
        self._pauses: deque[float] = deque(maxlen=self.PAUSES_KEPT)

    def heard(self, now: float) -> None:
        """Take note of a message that came now."""
        if self._last is not None and self._paced:
            self._pauses.append(now - self._last)
        self._last = now

    def age(self, now: float) -> float | None:
        """Return the age of the newest message; None before the first."""
        return None if self._last is None else now - self._last

    def level(self, now: float) -> Level:
        """Return how bad the silence is by now."""
        if self._config.warn_after == 0:
            return Level.OK
        if self._last is None:
            return Level.OK if self._paced else Level.STALE
        overdue = now - self._last - self._pace()
        if self._config.error_after and overdue > self._config.error_after:
            return Level.ERROR
        return Level.WARN if overdue > self._config.warn_after else Level.OK

    def _pace(self) -> float:
        """Return how long after the last message the next is due."""
        if not self._paced:
            return 0.0
        regular = (len(self._pauses) == self.PAUSES_KEPT
                   and max(self._pauses) <= self.LARGEST_PAUSE_RATIO * min(self._pauses))
        return max(self._pauses) if regular else float('inf')
