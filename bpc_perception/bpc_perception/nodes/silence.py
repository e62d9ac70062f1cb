"""Noticing that what came all the time comes no more."""

from __future__ import annotations

import time

from bpc_perception.nodes.diagnostics import Diagnostics

LIMIT = 2.0  # what comes tens of times a second is gone after this [s]


class Silence:
    """Warns while nothing comes of something that has come before."""

    def __init__(self, name: str, diagnostics: Diagnostics) -> None:
        self._warning = f'{name}: expected to hear it all the time, found it silent'
        self._diagnostics = diagnostics
        self._heard: float | None = None
        self._warned = 0.0

    def broken(self) -> None:
        """Something came."""
        self._heard = time.monotonic()

    def check(self) -> None:
        """Warn if it is silent, once a second, as the diagnostics are published."""
        now = time.monotonic()
        if self._heard is not None and now - self._heard > LIMIT and now - self._warned > 1.0:
            self._warned = now
            self._diagnostics.warn(self._warning)
