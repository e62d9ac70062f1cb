"""Follow the path of a print: the whole path comes now and then, what is new at once."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node

from bpc_interfaces.msg import DepositionPath, DepositionPathUpdate
from bpc_perception.core.path.deposition_path import DepositionPath as Path
from bpc_perception.core.path.growing_path import GrowingPath
from bpc_perception.messages import topics
from bpc_perception.messages.path import path_from_message
from bpc_perception.messages.stamps import check_frame, ConversionError


class PathFollower:
    """Subscribes to a path and its updates, and reports each change.

    Args:
        node: the node that subscribes.
        frame_id: the frame in which the path must be.
        on_path: gets the path as far as it is known; one without identifier when it was cleared.
        on_refusal: gets the reason why a message cannot be used.
    """

    def __init__(self, node: Node, frame_id: str, on_path: Callable[[Path], None],
                 on_refusal: Callable[[ConversionError], None]) -> None:
        self._frame_id = frame_id
        self._on_path = on_path
        self._on_refusal = on_refusal
        self.clear()
        node.create_subscription(DepositionPath, topics.PATH, self._on_whole, topics.PATH_QOS)
        node.create_subscription(DepositionPathUpdate, topics.PATH_UPDATE, self._on_update,
                                 topics.UPDATE_QOS)

    def clear(self) -> None:
        """Forget the path."""
        self._path = GrowingPath('', 0)

    def _on_whole(self, message: DepositionPath) -> None:
        known = self._path
        if (known.print_id == message.print_id and not message.finished
                and message.complete_until <= known.complete_until):
            return  # the updates came first
        if (path := self._converted(message)) is not None:
            self._path = GrowingPath(path.print_id, path.start_ns)
            self._extend(0, path)

    def _on_update(self, message: DepositionPathUpdate) -> None:
        if (path := self._converted(message.path)) is not None:
            if message.first == 0 and path.print_id != self._path.print_id:
                self._path = GrowingPath(path.print_id, path.start_ns)
            self._extend(message.first, path)

    def _converted(self, message: DepositionPath) -> Path | None:
        try:
            check_frame('deposition_path', message, self._frame_id)
            path = path_from_message(message)
        except ConversionError as error:
            self._on_refusal(error)
            return None
        # The topics may overtake each other: what was begun since is not what was cleared.
        return path if path.print_id or path.start_ns >= self._path.start_ns else None

    def _extend(self, first: int, path: Path) -> None:
        if self._path.extend(first, path):  # otherwise the next whole path has what is missing
            self._on_path(self._path.path())
