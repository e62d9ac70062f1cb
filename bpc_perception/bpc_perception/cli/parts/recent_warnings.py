"""The newest warnings; the same one is not shown over and over."""

from __future__ import annotations

import re
import time

MOST_KINDS = 100  # that are kept, the newest
SHOW_AGAIN_AFTER_S = 60.0  # without the warning
NUMBER = re.compile(r'[-+]?[\d.]+')


class RecentWarnings:
    """The last warning of each kind; warnings that differ only in numbers are of one kind."""

    def __init__(self) -> None:
        self._by_kind: dict[str, tuple[str, float]] = {}  # text, steady time [s]

    @property
    def texts(self) -> list[str]:
        """The warnings, the newest last."""
        return [text for text, _ in self._by_kind.values()]

    def add(self, text: str) -> bool:
        """Keep a warning; return whether to show it: it is new, or there was none for a while."""
        kind, now = NUMBER.sub('', text), time.monotonic()
        _, before = self._by_kind.pop(kind, ('', -SHOW_AGAIN_AFTER_S))
        self._by_kind[kind] = text, now
        if len(self._by_kind) > MOST_KINDS:
            del self._by_kind[next(iter(self._by_kind))]
        return now - before >= SHOW_AGAIN_AFTER_S
