"""The bag player: publishes robot and extruder of a recording in its own time, with /clock.

The camera driver delivers the captures of the recording, as in a live print.
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
from bpc_perception.recording.bag import Bag, BagMessage
from bpc_perception.recording.contents import find_topics, pose_topics
from bpc_perception.runtime.clock import steady_clock
from bpc_perception.runtime.diagnostics import Diagnostics
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.ros_arguments import remappings
from bpc_perception.runtime.run import run

CLOCK_PERIOD_S = 0.01
# On a busy machine the clock goes slower: a burst of poses would overflow queues.
LONGEST_STEP_S = 0.05
SETTLING_TIME_S = 1.0  # the recording starts when no listener was added for this long
LEAD_S = 0.3  # the clock stands at the start, until every node has forgotten the round before
TAIL_S = 1.0  # the clock goes on after the end, so that the last captures are measured too


class BagPlayerNode(Node):
    """Plays a recording as soon as all its listeners are there; ends with the recording."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('bag_player', **kwargs)
        self._config = NodeConfig(self, PlayerConfig()).value
        self._bag = Bag(self._config.bag, remappings(self._config.remap.split()))
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
        self._elapsed: float | None = None  # real time played in this round [s]; None = not begun
        self._ticked = 0.0
        self._messages: Iterator[BagMessage] = iter(())
        self._next: BagMessage | None = None
        self.create_timer(CLOCK_PERIOD_S, self._tick, clock=steady_clock())

    def _tick(self) -> None:
        if self._elapsed is None:
            if not self._settled():
                return
            self._rewind()
        assert self._elapsed is not None
        now = time.monotonic()
        self._elapsed += min(now - self._ticked, LONGEST_STEP_S)
        self._ticked = now
        now_ns = self._span[0] + round(max(self._elapsed, 0.0) * self._config.rate * 1e9)
        if self._elapsed > 0:
            self._publish_until(now_ns)
        self._clock_publisher.publish(Clock(clock=ns_to_stamp(now_ns)))
        duration = (self._span[1] - self._span[0]) * 1e-9 / self._config.rate
        if self._next is None and self._elapsed > duration + TAIL_S:
            if not self._config.loop:
                raise SystemExit(0)
            self._rewind()

    def _publish_until(self, now_ns: int) -> None:
        while self._next is not None and self._next.log_ns <= now_ns:
            name = self._names[self._next.topic]
            self._publishers_of[name].publish(self._next.message)
            self._diagnostics.count(name)
            self._next = next(self._messages, None)

    def _settled(self) -> bool:
        """Return whether robot and extruder have listeners, a camera is there, and none is new."""
        heard = {name: publisher.get_subscription_count()
                 for name, publisher in self._publishers_of.items()}
        needed = [heard.pop(topics.EXTRUSION), sum(heard.values())]
        needed += [self.count_publishers(name) for name in topics.CAMERA]
        # Nobody needs to listen to the camera: captures may be handed over in its process instead.
        counts = needed + [self.count_subscribers(name) for name in topics.CAMERA]
        now = time.monotonic()
        if counts != self._audience or not all(needed):
            self._audience, self._settling_since = counts, now
        return now - self._settling_since > SETTLING_TIME_S

    def _rewind(self) -> None:
        self._messages = self._bag.messages(set(self._names))
        self._next = next(self._messages, None)
        self._elapsed = -LEAD_S
        self._ticked = time.monotonic()


def main() -> None:
    """Run the node."""
    run(BagPlayerNode)


if __name__ == '__main__':
    main()
