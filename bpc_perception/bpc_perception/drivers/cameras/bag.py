"""Camera back end that delivers the captures of a recording at their times of recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from bpc_perception.core.capture.capture import Capture
from bpc_perception.drivers.cameras import CameraError
from bpc_perception.recording.bag import Bag, BagError
from bpc_perception.recording.contents import captures
from bpc_perception.runtime.ros_arguments import remappings


class BagCamera:
    """Delivers the captures of a bag along a clock that runs through its times of recording."""

    def __init__(self, bag: Bag) -> None:
        self._bag = bag
        self._captures: Iterator[tuple[int, Capture]] = captures(bag)
        self._next = next(self._captures, None)
        self._damage = ''
        self._last_ns = 0

    def connect(self) -> None:
        """Do nothing: a recording is always there."""

    def due(self, now_ns: int) -> bool:
        """Return whether the next capture had been recorded by ``now_ns``."""
        if now_ns < self._last_ns:  # the recording is played again
            self._captures = captures(self._bag)
            self._advance()
        self._last_ns = now_ns
        return bool(self._damage) or (self._next is not None and self._next[0] <= now_ns)

    def capture(self, now_ns: int) -> Capture:
        """Return the next recorded capture. Raises CameraError when none is due."""
        due = self.due(now_ns)
        if self._damage:
            damage, self._damage = self._damage, ''
            raise CameraError(damage)
        if not due or self._next is None:
            raise CameraError('capture: expected a recorded capture up to now, found none left'
                              '; play the recording again')
        capture = self._next[1]
        self._advance()
        return capture

    def _advance(self) -> None:
        """Read the next capture; damage there ends the recording and is reported once."""
        try:
            self._next = next(self._captures, None)
        except BagError as error:
            self._next, self._damage = None, f'recording: {error}'

    def notes(self) -> Mapping[str, object]:
        """Return nothing."""
        return {}

    def close(self) -> None:
        """Do nothing: nothing is held."""


def prepare(node: Node) -> Callable[[], BagCamera]:
    """Return a function that opens the bag named by the node's parameter ``bag``.

    Its parameter ``remap`` has rules as that of the bag player.
    """
    path = node.declare_parameter('bag', '', ParameterDescriptor(
        description='Recording whose captures are delivered', read_only=True)).value
    rules = node.declare_parameter('remap', '', ParameterDescriptor(
        description='Recorded topics to take in the place of others, TOPIC:=OTHER, with spaces '
        'between', read_only=True)).value
    return lambda: BagCamera(Bag(path, remappings(rules.split())))
