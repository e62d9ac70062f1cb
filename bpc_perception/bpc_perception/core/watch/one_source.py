"""Tell whether the messages of a topic come from one publisher at a time."""

from __future__ import annotations

from math import inf

MOST_LOST = 1000  # messages in a row, of a stream that is not repeated
# A publisher that is started again is silent for longer, and for this many of its pauses.
SILENCE_S, SILENT_PAUSES = 0.3, 3.0
SETTLING_S, SETTLING_PAUSES = 1.0, 1.5  # the same for how long to look who goes on
MEMORY_S = 60.0  # two changes within this time are no accident


class OneSource:
    """Sees by the numbers of messages when two publishers send at a time.

    Each publisher counts its messages, and they come in order. So a number that does not follow
    the last one is of another publisher: of one that was started again, after some silence, or of
    a second one. As long as two alternate, nobody can tell whose a message is, and none is taken.
    """

    def __init__(self) -> None:
        self._last = 0  # number; 0 = none came
        self._heard = -inf  # when the last one came [s]
        self._pause = SETTLING_S  # between two messages of one publisher [s]
        self._changed = self._refused_until = -inf  # [s]

    def takes(self, number: int, now: float) -> bool:
        """Take note of a message's number, from 1, at a time [s]; return whether to use it."""
        silence = now - self._heard
        if 0 < number - self._last <= MOST_LOST or not self._last:
            self._pause = silence if self._last else self._pause
        elif silence < max(SILENCE_S, SILENT_PAUSES * self._pause):
            again = now - self._changed < MEMORY_S
            self._changed = now
            self._refused_until = now + (
                MEMORY_S if again else max(SETTLING_S, SETTLING_PAUSES * self._pause))
        self._last, self._heard = number, now
        return now >= self._refused_until
