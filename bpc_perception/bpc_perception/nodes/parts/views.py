"""Publish views of a result for people, while someone looks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from bpc_perception.core.result import Result
from bpc_perception.display.layers import NEWEST
from bpc_perception.messages import topics
from bpc_perception.messages.views import (
    deviation_message,
    markers_message,
    no_view,
    overlay_message,
    width_message,
)


class Views:
    """Publishers of the views of a result; a view without subscribers costs nothing."""

    def __init__(self, node: Node, frame_id: str) -> None:
        self._frame_id = frame_id
        self._shown: set[str] = set()
        self._publishers = {name: node.create_publisher(kind, name, topics.VIEW_QOS)
                            for name, kind in topics.VIEWS.items()}

    def publish(self, result: Result, layer: int = NEWEST) -> None:
        """Publish those views of a measured result that have subscribers.

        Args:
            result: the result.
            layer: which layer the overlay shows.
        """
        make: dict[str, Callable[[], Any]] = {
            topics.MARKERS: lambda: markers_message(result, self._frame_id),
            topics.OVERLAY: lambda: overlay_message(result, layer),
            topics.WIDTH: lambda: width_message(result),
            topics.DEVIATION: lambda: deviation_message(result)}
        for name, publisher in self._publishers.items():
            if publisher.get_subscription_count():
                publisher.publish(make[name]())
                self._shown.add(name)

    def clear(self) -> None:
        """Let those who look, now or later, see that there is no print any more."""
        for name in self._shown:
            self._publishers[name].publish(no_view(topics.VIEWS[name], self._frame_id))
        self._shown.clear()
