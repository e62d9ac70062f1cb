"""Publish a growing path: what is new at once, the whole path as often as it may cost."""

from __future__ import annotations

from typing import NamedTuple

from nav_msgs.msg import Path
from rclpy.node import Node

from bpc_interfaces.msg import DepositionPath, DepositionPathUpdate
from bpc_perception.core.path.growing_path import GrowingPath
from bpc_perception.messages import topics
from bpc_perception.messages.path import path_to_message, path_to_nav
from bpc_perception.runtime.rate_limit import Allowance

WHOLE_PATH_TIME_SHARE = 0.05  # of the time may go into sending the whole path, however long it is


class _State(NamedTuple):
    """How far a path has come; the path is unchanged while this is."""

    print_id: str
    complete_until: float
    finished: bool


class PathPublisher:
    """Publishes a path, its updates, and a view of it."""

    def __init__(self, node: Node, frame_id: str) -> None:
        self._frame_id = frame_id
        # The state of the path at the last update, the last whole path, and the last view.
        self._updated: _State | None = None
        self._published: _State | None = None
        self._viewed: _State | None = None
        self._points_sent = 0
        self._whole = Allowance(WHOLE_PATH_TIME_SHARE)
        self._view = Allowance(WHOLE_PATH_TIME_SHARE)
        self._updates = node.create_publisher(
            DepositionPathUpdate, topics.PATH_UPDATE, topics.UPDATE_QOS)
        self._paths = node.create_publisher(DepositionPath, topics.PATH, topics.PATH_QOS)
        self._nav_paths = node.create_publisher(Path, topics.NAV_PATH, topics.PATH_QOS)

    def publish(self, growing: GrowingPath) -> None:
        """Publish what is new of a path in the robot base frame."""
        state = _State(growing.print_id, growing.complete_until, growing.finished)
        new_print = self._updated is None or self._updated.print_id != growing.print_id
        if state != self._updated:
            self._publish_update(growing, 0 if new_print else self._points_sent)
            self._updated = state
        if state != self._published and (new_print or self._whole.due()):
            with self._whole.spent():
                self._paths.publish(path_to_message(growing.path(), self._frame_id))
            self._published = state
        if state != self._viewed and self._is_viewed() and self._view.due():
            with self._view.spent():
                self._nav_paths.publish(path_to_nav(growing.path(), self._frame_id))
            self._viewed = state

    def clear(self, stamp_ns: int) -> None:
        """Publish that from this time on [ns] there is no print."""
        none = GrowingPath('', stamp_ns)
        none.complete_until, none.finished = 0.0, True
        self._publish_update(none, 0)
        self._paths.publish(path_to_message(none.path(), self._frame_id))
        self._nav_paths.publish(path_to_nav(none.path(), self._frame_id))
        self._updated = self._published = self._viewed = None

    def _publish_update(self, growing: GrowingPath, first: int) -> None:
        self._points_sent = len(growing)
        self._updates.publish(DepositionPathUpdate(
            first=first, path=path_to_message(growing.path(first), self._frame_id)))

    def _is_viewed(self) -> bool:
        return bool(self._nav_paths.get_subscription_count())
