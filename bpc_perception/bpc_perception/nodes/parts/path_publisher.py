"""A growing path on its topics: what is new at once, the whole of it as often as it may cost."""

from __future__ import annotations

from nav_msgs.msg import Path
from rclpy.node import Node

from bpc_interfaces.msg import DepositionPath, DepositionPathUpdate
from bpc_perception.core.path.growing_path import GrowingPath
from bpc_perception.messages import topics
from bpc_perception.messages.path import path_to_message, path_to_nav
from bpc_perception.runtime.rate_limit import Allowance

State = tuple[str, float, bool]  # of a path: print, complete until, finished
PATH_SHARE = 0.05  # of the time that sending the whole path may take, however long it is


class PathPublisher:
    """Publishes a path, its updates, and a view of it."""

    def __init__(self, node: Node, frame_id: str) -> None:
        self._frame_id = frame_id
        # The state of the path when the update, the whole, and that for viewers were published.
        self._updated: State | None = None
        self._published: State | None = None
        self._viewed: State | None = None
        self._points_sent = 0
        self._whole, self._view = Allowance(PATH_SHARE), Allowance(PATH_SHARE)
        self._updates = node.create_publisher(
            DepositionPathUpdate, topics.PATH_UPDATE, topics.PATH_UPDATE_QOS)
        self._paths = node.create_publisher(DepositionPath, topics.PATH, topics.PATH_QOS)
        self._nav_paths = node.create_publisher(Path, topics.NAV_PATH, topics.PATH_QOS)

    def publish(self, growing: GrowingPath) -> None:
        """Publish what is new."""
        state = (growing.print_id, growing.complete_until, growing.finished)
        new_print = self._updated is None or self._updated[0] != growing.print_id
        if state != self._updated:
            first = 0 if new_print else self._points_sent
            self._updated, self._points_sent = state, len(growing)
            self._updates.publish(DepositionPathUpdate(
                first=first, path=path_to_message(growing.path(first), self._frame_id)))
        if state != self._published and (new_print or self._whole.due()):
            self._published = state
            with self._whole.spent():
                self._paths.publish(path_to_message(growing.path(), self._frame_id))
        if (state != self._viewed and self._nav_paths.get_subscription_count()
                and self._view.due()):
            self._viewed = state
            with self._view.spent():
                self._nav_paths.publish(path_to_nav(growing.path(), self._frame_id))
