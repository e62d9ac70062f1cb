"""The parts of one capture, brought together by their exact stamp."""

from __future__ import annotations

from typing import Generic, TypeVar

Part = TypeVar('Part')


class StampPairer(Generic[Part]):
    """Collects one part of each kind for each stamp; parts may come in any order."""

    # Sets that never become complete must not fill memory; a capture may be 46 MB.
    MAXIMUM_INCOMPLETE = 4

    def __init__(self, kinds: tuple[str, ...], most: int = MAXIMUM_INCOMPLETE) -> None:
        """Collect these kinds of parts, for ``most`` incomplete sets at once."""
        self._kinds = kinds
        self._most = most
        self._incomplete: dict[int, dict[str, Part]] = {}
        self._received: dict[int, int] = {}

    def add(self, kind: str, stamp_ns: int, part: Part,
            received_ns: int = 0) -> dict[str, Part] | None:
        """Add a part, received at this time [ns].

        Return the whole set, by kind, if the part was the last that was missing.
        """
        parts = self._incomplete.setdefault(stamp_ns, {})
        self._received.setdefault(stamp_ns, received_ns)
        parts[kind] = part
        if len(parts) < len(self._kinds):
            return None
        self._remove(stamp_ns)
        return parts

    def expired(self, before_ns: int) -> list[tuple[str, ...]]:
        """Give up sets begun before this time [ns], and the oldest if there are too many.

        Return the kinds that each of them lacks.
        """
        ordered = sorted(self._incomplete)
        surplus = ordered[:-self._most]
        given_up = [self._remove(stamp) for stamp in ordered
                    if stamp in surplus or self._received[stamp] < before_ns]
        return [tuple(kind for kind in self._kinds if kind not in parts) for parts in given_up]

    def overtaken(self, stamp_ns: int, kind: str) -> int:
        """Forget sets older than this stamp with a part of only this kind; return how many.

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
