"""The bag player: robot and extruder of a recording out, in its own time, with /clock.

The captures of the recording are left to the camera driver, as in a live print.
"""

from __future__ import annotations

from collections.abc import Iterator
import time
from typing import Any

from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from bpc_perception.core.config import PlayerConfig
from bpc_perception.messages import topics
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.contents import find_topics, pose_topics
from bpc_perception.runtime.clock import steady_clock
from bpc_perception.runtime.diagnostics import Diagnostics
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.run import run

CLOCK_PERIOD = 0.01  # [s]
# When the machine is busy the clock goes slower: a burst of poses would overflow queues [s].
LONGEST_STEP = 0.05
SETTLED = 1.0  # nobody else has begun to listen for so long before the start [s]
LEAD = 0.3  # the clock stands at the start, until every node has forgotten a round before [s]
TAIL = 1.0  # the clock goes on, so that what was recorded last is measured too [s]


class BagPlayerNode(Node):
    """Plays a recording once everything that listens is there; ends with its end."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('bag_player', **kwargs)
        self._config = NodeConfig(self, PlayerConfig()).value
        self._bag = Bag(self._config.bag)
        robot = pose_topics(self._bag) or {topics.POSE: topics.ROBOT[topics.POSE]}
        played = robot | {topics.EXTRUSION: topics.PRINT[topics.EXTRUSION]}
        self._names = find_topics(self._bag, played)
        self._span = self._bag.span()
        self._publishers_of = {name: self.create_publisher(kind, name, topics.EXTRUSION_QOS)
                               for name, kind in played.items()}
        self._clock_publisher = self.create_publisher(Clock, '/clock', 1)
        self._diagnostics = Diagnostics(self)
        self._audience: list[int] = []
        self._settling_since = 0.0
        self._elapsed: float | None = None  # of this round, at the speed of the clock [s]
        self._ticked = 0.0
        self._messages: Iterator[tuple[str, int, Any]] = iter(())
        self._next: tuple[str, int, Any] | None = None
        self.create_timer(CLOCK_PERIOD, self._tick, clock=steady_clock())

    def _tick(self) -> None:
        if self._elapsed is None:
            if not self._settled():
                return
            self._rewind()
        assert self._elapsed is not None
        now = time.monotonic()
        self._elapsed += min(now - self._ticked, LONGEST_STEP)
        self._ticked = now
        now_ns = self._span[0] + round(max(self._elapsed, 0.0) * self._config.rate * 1e9)
        while self._elapsed > 0 and self._next is not None and self._next[1] <= now_ns:
            topic, _, message = self._next
            self._publishers_of[self._names[topic]].publish(message)
            self._diagnostics.count(self._names[topic])
            self._next = next(self._messages, None)
        self._clock_publisher.publish(Clock(clock=ns_to_stamp(now_ns)))
        duration = (self._span[1] - self._span[0]) * 1e-9 / self._config.rate
        if self._next is None and self._elapsed > duration + TAIL:
            if not self._config.loop:
                raise SystemExit(0)
            self._rewind()

    def _settled(self) -> bool:
        """Whether robot and extruder have listeners, a camera is there, and no more are coming."""
        heard = {name: publisher.get_subscription_count()
                 for name, publisher in self._publishers_of.items()}
        needed = [heard.pop(topics.EXTRUSION), sum(heard.values())]
        needed += [self.count_publishers(name) for name in topics.CAMERA]
        # Captures may be handed over in the camera's process instead.
        counts = needed + [self.count_subscribers(name) for name in topics.CAMERA]
        now = time.monotonic()
        if counts != self._audience or not all(needed):
            self._audience, self._settling_since = counts, now
        return now - self._settling_since > SETTLED

    def _rewind(self) -> None:
        self._messages = self._bag.messages(set(self._names))
        self._next = next(self._messages, None)
        self._elapsed = -LEAD
        self._ticked = time.monotonic()


def main() -> None:
    """Run the node."""
    run(BagPlayerNode)


if __name__ == '__main__':
    main()
