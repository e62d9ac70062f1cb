"""Camera back end that delivers the captures of a recording when their time has come."""

from __future__ import annotations

from collections.abc import Iterator

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from bpc_perception.bag import Bag
from bpc_perception.core.capture import Capture
from bpc_perception.drivers import CameraError
from bpc_perception.recording import captures


class BagCamera:
    """Plays the captures of a bag along a clock that runs through its recording times."""

    def __init__(self, bag: Bag) -> None:
        self._bag = bag
        self._captures: Iterator[tuple[int, Capture]] = captures(bag)
        self._next = next(self._captures, None)
        self._last_ns = 0

    def due(self, now_ns: int) -> bool:
        """Whether the next capture had been recorded by now."""
        if now_ns < self._last_ns:  # the recording is played again
            self._captures = captures(self._bag)
            self._next = next(self._captures, None)
        self._last_ns = now_ns
        return self._next is not None and self._next[0] <= now_ns

    def capture(self, now_ns: int) -> Capture:
        """The next recorded capture, if it is due."""
        if not self.due(now_ns) or self._next is None:
            raise CameraError('capture: expected a recorded capture up to now, found none left')
        capture = self._next[1]
        self._next = next(self._captures, None)
        return capture

    def close(self) -> None:
        """Nothing is held."""


def open_camera(node: Node) -> BagCamera:
    """A camera for the bag named by the node's parameter ``bag``."""
    path = node.declare_parameter('bag', '', ParameterDescriptor(
        description='Recording whose captures are delivered', read_only=True)).value
    return BagCamera(Bag(path))
