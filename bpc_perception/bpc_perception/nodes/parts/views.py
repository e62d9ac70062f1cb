"""What the thickness node publishes for people to look at, while someone does."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node

from bpc_perception.core.session import Result
from bpc_perception.messages import topics
from bpc_perception.messages.views import (
    deviation_message,
    markers_message,
    overlay_message,
    width_message,
)

MESSAGES: dict[str, Any] = {
    topics.MARKERS: markers_message, topics.OVERLAY: overlay_message,
    topics.WIDTH: width_message, topics.DEVIATION: deviation_message}


class Views:
    """Publishers of pictures of a result; one that nobody listens to costs nothing."""

    def __init__(self, node: Node, frame_id: str) -> None:
        self._frame_id = frame_id
        self._publishers = {name: node.create_publisher(kind, name, topics.VIEW_QOS)
                            for name, kind in topics.VIEWS.items()}

    def publish(self, result: Result) -> None:
        """Publish a measured result, as far as someone listens."""
        for name, publisher in self._publishers.items():
            if publisher.get_subscription_count():
                publisher.publish(MESSAGES[name](result, self._frame_id))
