"""When a device samples, whatever the computer that plays it is busy with."""

from __future__ import annotations

from collections.abc import Iterator

MOST_BEHIND_NS = 500_000_000  # what a device sends late; of a longer pause it skips the rest


class SteadyRate:
    """Moments of a steady rate: a controller leaves none out, though some may come late."""

    def __init__(self, rate: float) -> None:
        """``rate`` in Hz."""
        self._period_ns = round(1e9 / rate)
        self._next_ns: int | None = None

    def due(self, now_ns: int) -> Iterator[int]:
        """Yield the moments [ns] up to now that were not yielded before; the first is now."""
        if self._next_ns is None or not (
                -self._period_ns <= now_ns - self._next_ns <= MOST_BEHIND_NS):
            self._next_ns = now_ns
        while self._next_ns <= now_ns:
            yield self._next_ns
            self._next_ns += self._period_ns
