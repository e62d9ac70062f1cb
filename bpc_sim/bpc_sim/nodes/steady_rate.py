"""The sampling times of a device, even if the computer that simulates it is held up."""

from __future__ import annotations

from collections.abc import Iterator

# Samples of a pause up to this are sent late; a longer one is skipped. A busy computer holds a
# process up for most of a second; a robot goes on meanwhile.
MAX_DELAY_NS = 2_000_000_000


class SteadyRate:
    """Times at a steady rate: none is left out, though some may come late."""

    def __init__(self, rate: float) -> None:
        """``rate`` in Hz."""
        self._period_ns = round(1e9 / rate)
        self._next_ns: int | None = None

    def due(self, now_ns: int) -> Iterator[int]:
        """Yield the times [ns] up to now that were not yielded before; the first is now."""
        if self._next_ns is None or not (
                -self._period_ns <= now_ns - self._next_ns <= MAX_DELAY_NS):
            self._next_ns = now_ns
        while self._next_ns <= now_ns:
            yield self._next_ns
            self._next_ns += self._period_ns
