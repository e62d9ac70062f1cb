"""How long to wait before looking again for a device that is gone."""

from __future__ import annotations


class BackOff:
    """Pauses that double from one failure to the next, up to a longest; all times in seconds."""

    def __init__(self, shortest: float = 0.25, longest: float = 5.0) -> None:
        self._shortest, self._longest = shortest, longest
        self._pause, self._until = shortest, 0.0

    def waiting(self, now: float) -> float:
        """Return how long to wait before the next attempt; 0 = it is time."""
        return max(self._until - now, 0.0)

    def failed(self, now: float) -> None:
        """Begin a pause; the next one will be longer."""
        self._until = now + self._pause
        self._pause = min(2 * self._pause, self._longest)

    def succeeded(self) -> None:
        """End the pause; the next one will be the shortest."""
        self._pause, self._until = self._shortest, 0.0
