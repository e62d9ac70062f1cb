"""Whose stamps are by which clock, from the times at which messages were recorded.

The recorder's own clock may be any: then the stamps of all topics are off it by about the same. A
topic that differs from the others has a clock of its own, and what it says is of another moment.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Set
from statistics import median

RECENT_COUNT = 9  # messages of a topic that tell how its clock goes
LARGEST_LEAD_S = 0.1  # as live, watch.maximum_lead
# The fastest message of a topic may be so much later than that of another. A camera may take long
# from its stamp until it sends.
LATEST_S, LATEST_CAMERA_S = 0.3, 2.0
JUMP_S = 1.0  # by which the recorder's clock goes on at once only if it was set
MOST_AT_ONCE = 8  # messages are recorded at one time, unless the recorder's clock stands
ADVICE = 'let chrony or PTP set the clocks of all computers'


class Clocks:
    """Compares the stamps of topics with the times at which they were recorded.

    Args:
        camera: topics of the camera.
    """

    def __init__(self, camera: Set[str]) -> None:
        self._camera = camera
        self._last_ns = 0  # by the recorder's clock
        self._same = 0  # messages in a row at that time
        self._leads: dict[str, deque[float]] = {}
        self._least_lag: dict[str, float] = {}

    def note(self, topic: str, log_ns: int, stamp_ns: int) -> bool:
        """Take note of a message recorded at ``log_ns``; return whether that tells anything."""
        self._same = self._same + 1 if log_ns == self._last_ns else 0
        if self._same > MOST_AT_ONCE:
            return False  # a clock that stands says nothing
        if not 0 <= log_ns - self._last_ns <= JUMP_S * 1e9:
            self._leads.clear()
            self._least_lag.clear()
        self._last_ns = log_ns
        lead = (stamp_ns - log_ns) * 1e-9
        self._leads.setdefault(topic, deque(maxlen=RECENT_COUNT)).append(lead)
        return True

    def lead(self, topic: str, log_ns: int, stamp_ns: int) -> float:
        """Return how far a noted message is ahead of the clock of the others [s]; 0 = it is not.

        The clock that most go by is that of the topic that is least ahead.
        """
        usual = min((median(leads) + (LATEST_CAMERA_S if other in self._camera else 0.0)
                     for other, leads in self._leads.items()), default=0.0)
        lead = (stamp_ns - log_ns) * 1e-9
        if lead - max(usual, 0.0) > LARGEST_LEAD_S:
            return lead - max(usual, 0.0)
        self._least_lag[topic] = min(-lead, self._least_lag.get(topic, -lead))
        return 0.0

    def late(self) -> dict[str, float]:
        """Return the topics that are behind the others, and by how much [s]."""
        first = min(self._least_lag.values(), default=0.0)
        return {topic: lag - first for topic, lag in self._least_lag.items()
                if lag - first > (LATEST_CAMERA_S if topic in self._camera else LATEST_S)}
