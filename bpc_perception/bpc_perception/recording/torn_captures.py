"""Captures of which not all topics came, as when messages are larger than a computer can take."""

from __future__ import annotations

from collections.abc import Collection

PATIENCE_S = 2.0  # between the first and the last topic of a capture


class TornCaptures:
    """Counts captures of which one topic came, but not all of the others.

    Args:
        sure: topic whose small messages come also to a slow subscriber.
        others: topics that belong to it, by stamp.
    """

    def __init__(self, sure: str, others: Collection[str]) -> None:
        self._sure = sure
        self._topics = {sure, *others}
        self._came: dict[int, tuple[float, set[str]]] = {}  # when the first did [s], and which

    def add(self, topic: str, stamp_ns: int, now: float) -> None:
        """Take note of a message with this stamp [ns] that came now [s]."""
        if topic in self._topics:
            _, came = self._came.setdefault(stamp_ns, (now, set()))
            came.add(topic)
            if came == self._topics:
                del self._came[stamp_ns]

    def take(self, now: float) -> int:
        """Return how many captures are torn for good by now [s], not counting those of before."""
        late = [stamp_ns for stamp_ns, (first, _) in self._came.items()
                if now - first > PATIENCE_S]
        return sum(self._sure in self._came.pop(stamp_ns)[1] for stamp_ns in late)
