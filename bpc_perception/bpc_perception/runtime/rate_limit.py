"""Limit how much of the time a costly task may take."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import time


class Allowance:
    """Lets a task take at most a share of the time, however long it takes each time.

    It also allows the task at most once every ``period`` seconds.
    """

    def __init__(self, share: float, period: float = 0.1) -> None:
        self._share = share
        self._period = period
        self._next = 0.0

    def due(self) -> bool:
        """Return whether the task may be done again."""
        return time.monotonic() >= self._next

    @contextmanager
    def spent(self) -> Iterator[None]:
        """Count the time of the block."""
        start = time.monotonic()
        yield
        cost = time.monotonic() - start
        self._next = start + max(self._period, cost / self._share)
