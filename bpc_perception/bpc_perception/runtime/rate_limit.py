"""Doing what is costly only as often as a share of the time allows."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import time


class Allowance:
    """Lets something take at most a share of the time, however long it takes each time.

    And not more often than every ``period`` seconds.
    """

    def __init__(self, share: float, period: float = 0.1) -> None:
        self._share = share
        self._period = period
        self._next = 0.0

    def due(self) -> bool:
        """Whether it may be done again."""
        return time.monotonic() >= self._next

    @contextmanager
    def spent(self) -> Iterator[None]:
        """What is done in the block counts."""
        start = time.monotonic()
        yield
        cost = time.monotonic() - start
        self._next = start + max(self._period, cost / self._share)
