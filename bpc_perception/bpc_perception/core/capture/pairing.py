"""Bringing together the parts of one capture by their exact stamp."""

from __future__ import annotations

from typing import Generic, TypeVar

Part = TypeVar('Part')


class StampPairer(Generic[Part]):
    """Collects one part of each kind a stamp; parts may come in any order."""

    # What never becomes complete must not fill memory; a capture may be 46 MB.
    DEPTH = 4

    def __init__(self, kinds: tuple[str, ...]) -> None:
        self._kinds = kinds
        self._incomplete: dict[int, dict[str, Part]] = {}
        self._received: dict[int, int] = {}

    def add(self, kind: str, stamp_ns: int, part: Part,
            received_ns: int = 0) -> dict[str, Part] | None:
        """Take a part, received at this time; the whole set if it was the last missing."""
        parts = self._incomplete.setdefault(stamp_ns, {})
        self._received.setdefault(stamp_ns, received_ns)
        parts[kind] = part
        if len(parts) < len(self._kinds):
            return None
        self._remove(stamp_ns)
        return parts

    def expired(self, before_ns: int) -> list[tuple[str, ...]]:
        """Give up sets begun before this time, and all but the newest; the kinds they lack."""
        ordered = sorted(self._incomplete)
        surplus = ordered[:-self.DEPTH] if len(ordered) > self.DEPTH else []
        given_up = [stamp for stamp in ordered
                    if stamp in surplus or self._received[stamp] < before_ns]
        removed = [self._remove(stamp) for stamp in given_up]
        return [tuple(kind for kind in self._kinds if kind not in parts) for parts in removed]

    def overtaken(self, stamp_ns: int, kind: str) -> int:
        """Forget sets older than this stamp of which only one kind came; how many.

        The other kinds, in shorter queues, had to give way to newer ones.
        """
        lost = [stamp for stamp, parts in self._incomplete.items()
                if stamp < stamp_ns and set(parts) == {kind}]
        for stamp in lost:
            self._remove(stamp)
        return len(lost)

    def clear(self) -> None:
        """Forget all parts."""
        self._incomplete.clear()
        self._received.clear()

    def _remove(self, stamp_ns: int) -> dict[str, Part]:
        del self._received[stamp_ns]
        return self._incomplete.pop(stamp_ns)
