"""The clocks of a node."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.clock import Clock, ClockType, JumpHandle, JumpThreshold, ROSClock
from rclpy.duration import Duration
from rclpy.node import Node

from bpc_perception.messages.stamps import ConversionError


def steady_clock() -> Clock:
    """Return a clock that runs on while simulated time stands still, for timeouts."""
    return Clock(clock_type=ClockType.STEADY_TIME)


def expect_not_ahead(node: Node, name: str, stamp_ns: int, maximum_lead: float) -> None:
    """Raise ConversionError for a stamp more than ``maximum_lead`` [s] in the future.

    With simulated time nothing is raised: each node gets the time by its own message, so a stamp
    may be ahead of the node's clock.
    """
    clock = node.get_clock()
    simulated = isinstance(clock, ROSClock) and clock.ros_time_is_active
    if not simulated and stamp_ns - clock.now().nanoseconds > maximum_lead * 1e9:
        raise ConversionError(f'{name}: expected a stamp of the past, found one of the future; '
                              'do the clocks agree?')


def on_jump_back(node: Node, forget: Callable[[], None]) -> JumpHandle:
    """Call ``forget`` when the node's clock goes back, for instance when a recording is replayed.

    Keep the returned handle: without it the clock drops the callback.
    """
    def jumped(_: object) -> None:
        node.get_logger().warning('clock went back: everything received is forgotten')
        forget()

    return node.get_clock().create_jump_callback(
        JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1),
                      on_clock_change=False), post_callback=jumped)
