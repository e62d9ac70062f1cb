"""How long to wait before a device that is gone is looked for again."""

from __future__ import annotations


class BackOff:
    """Pauses that double from one failure to the next, up to a longest; times in seconds."""

    def __init__(self, shortest: float = 0.25, longest: float = 5.0) -> None:
        self._shortest, self._longest = shortest, longest
        self._pause, self._until = shortest, 0.0

    def waiting(self, now: float) -> float:
        """For how long still no attempt is to be made; 0 = it is time."""
        return max(self._until - now, 0.0)

    def failed(self, now: float) -> None:
        """Wait, longer than the last time."""
        self._until = now + self._pause
        self._pause = min(2 * self._pause, self._longest)

    def succeeded(self) -> None:
        """Begin with the shortest pause next time."""
        self._pause, self._until = self._shortest, 0.0
