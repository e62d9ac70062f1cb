"""Clocks of a node."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.clock import Clock, ClockType, JumpHandle, JumpThreshold
from rclpy.duration import Duration
from rclpy.node import Node


def steady_clock() -> Clock:
    """A clock that runs on while simulated time stands still: for timeouts and heartbeats."""
    return Clock(clock_type=ClockType.STEADY_TIME)


def on_jump_back(node: Node, forget: Callable[[], None]) -> JumpHandle:
    """Call ``forget`` when the node's clock goes back, as when a recording is played again.

    The clock forgets the callback when the returned handle is dropped.
    """
    def jumped(_: object) -> None:
        node.get_logger().warning('clock went back: everything received is forgotten')
        forget()

    return node.get_clock().create_jump_callback(
        JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1),
                      on_clock_change=False), post_callback=jumped)
