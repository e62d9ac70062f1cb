"""Whose stamps are by which clock, from the times at which messages came or were recorded.

The recorder's own clock may be any: then the stamps of all topics are off it by about the same. A
topic that differs from the others has a clock of its own, and what it says is of another moment.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Set
from math import inf
from statistics import median

RECENT_COUNT = 9  # messages of a topic that tell how its clock goes
LARGEST_LEAD_S = 0.1  # as live, watch.maximum_lead
# The fastest message of a topic may be so much later than that of another. A camera may take long
# from its stamp until it sends.
LATEST_S, LATEST_CAMERA_S = 0.3, 2.0
WINDOW_S = 5.0  # in which a topic's fastest message counts: what was held up is not behind
STEADY_S = 2.0  # for which a topic has to be behind, live
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
        self._recent: dict[str, deque[tuple[int, float]]] = {}  # when recorded, and lead

    def note(self, topic: str, log_ns: int, stamp_ns: int) -> bool:
        """Take note of a message recorded at ``log_ns``; return whether that tells anything."""
        self._same = self._same + 1 if log_ns == self._last_ns else 0
        if self._same > MOST_AT_ONCE:
            return False  # a clock that stands says nothing
        if not 0 <= log_ns - self._last_ns <= JUMP_S * 1e9:
            self._leads.clear()
            self._least_lag.clear()
            self._recent.clear()
        self._last_ns = log_ns
        lead = (stamp_ns - log_ns) * 1e-9
        self._leads.setdefault(topic, deque(maxlen=RECENT_COUNT)).append(lead)
        recent = self._recent.setdefault(topic, deque())
        # What is slower than a later one is never the fastest of those that are left.
        while recent and (recent[-1][1] <= lead):
            recent.pop()
        recent.append((log_ns, lead))
        return True

    def lag(self, topic: str, log_ns: int) -> float:
        """Return how far a topic is behind the clock of the others by now [s]; 0 = it is not.

        A camera may be late. A topic that was held up for a while is not behind.
        """
        if topic in self._camera:
            return 0.0
        fastest = {other: self._fastest(other, log_ns) for other, leads in self._leads.items()
                   if other not in self._camera and len(leads) == RECENT_COUNT}
        own = fastest.get(topic, inf)
        if max(fastest.values(), default=-inf) - own <= LATEST_S:
            return 0.0  # as a rule
        latest = self._usual() + LARGEST_LEAD_S  # what is ahead is no measure for others
        others = max((lead for lead in fastest.values() if lead <= latest), default=-inf)
        lag = others - own
        return lag if lag > LATEST_S else 0.0

    def _usual(self) -> float:
        """Return how far the clock that most go by is ahead of the recorder's [s]."""
        return max(0.0, min((
            median(leads) + (LATEST_CAMERA_S if topic in self._camera else 0.0)
            for topic, leads in self._leads.items()), default=0.0))

    def _fastest(self, topic: str, log_ns: int) -> float:
        """Return the greatest lead of a topic's messages of the last ``WINDOW_S`` [s]."""
        recent = self._recent[topic]
        while len(recent) > 1 and log_ns - recent[0][0] > WINDOW_S * 1e9:
            recent.popleft()
        return recent[0][1]

    def lead(self, topic: str, log_ns: int, stamp_ns: int) -> float:
        """Return how far a noted message is ahead of the clock of the others [s]; 0 = it is not.

        The clock that most go by is that of the topic that is least ahead.
        """
        usual = self._usual()
        lead = (stamp_ns - log_ns) * 1e-9
        if lead - usual > LARGEST_LEAD_S:
            return lead - usual
        self._least_lag[topic] = min(-lead, self._least_lag.get(topic, -lead))
        return 0.0

    def late(self) -> dict[str, float]:
        """Return the topics that are behind the others, and by how much [s]."""
        first = min(self._least_lag.values(), default=0.0)
        return {topic: lag - first for topic, lag in self._least_lag.items()
                if lag - first > (LATEST_CAMERA_S if topic in self._camera else LATEST_S)}


class SteadyClocks:
    """Compares the clocks of sources live, where messages of a while may come at once."""

    def __init__(self) -> None:
        self._clocks = Clocks(frozenset())
        self._since: dict[str, int] = {}

    def behind(self, topic: str, now_ns: int, stamp_ns: int) -> float:
        """Return how far a message's clock is behind that of another topic [s].

        0 = it is not, or not for long enough to tell a clock from a delay.
        """
        told = self._clocks.note(topic, now_ns, stamp_ns)
        lag = self._clocks.lag(topic, now_ns) if told else 0.0
        if not lag:
            self._since.pop(topic, None)
            return 0.0
        since = self._since.setdefault(topic, now_ns)
        return lag if now_ns - since >= STEADY_S * 1e9 else 0.0
