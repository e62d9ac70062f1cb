"""Pack the images and clouds of captures while they are recorded."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, NamedTuple

from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Image, PointCloud2, PointField

from bpc_perception.recording.storage.planes import Layout, layout_of, pack

PACKED_TYPES = (Image, PointCloud2)
MOST_WAITING = 4  # parts of captures that are packed; a large one has 37 MB
# Bytes behind the array in a serialized message: none behind that of an image; behind that of a
# cloud one that says whether it is dense, and what some add to fill up four.
IMAGE_TAILS, CLOUD_TAILS = range(4), range(1, 5)
POINT = tuple((name, 4 * place, PointField.FLOAT32) for place, name in enumerate('xyz'))


class Entry(NamedTuple):
    """A message to be recorded: its topic, when it came [ns], and its bytes."""

    topic: str
    log_ns: int
    data: bytes


class CapturePacker:
    """Packs the parts of captures in a thread of its own, and gives them back in order."""

    def __init__(self, kinds: Mapping[str, Any]) -> None:
        """Pack the messages of these topics; ``kinds`` are their classes."""
        self._kinds = {topic: kind for topic, kind in kinds.items() if kind in PACKED_TYPES}
        self._thread = ThreadPoolExecutor(1, 'pack')
        self._waiting: deque[tuple[Entry, Future[bytes] | None]] = deque()  # None = as it is

    @property
    def topics(self) -> set[str]:
        """The topics whose messages are packed."""
        return set(self._kinds)

    def take(self, entry: Entry) -> bool:
        """Begin to pack a message; return False for one of another topic.

        While too many are being packed it stays as it is, and only keeps its turn.
        """
        kind = self._kinds.get(entry.topic)
        if kind is None:
            return False
        busy = sum(future is not None and not future.done() for _, future in self._waiting)
        self._waiting.append((entry, self._thread.submit(packed, entry.data, kind)
                              if busy < MOST_WAITING else None))
        return True

    def packed(self) -> Iterator[Entry]:
        """Yield the messages that are packed by now."""
        while self._waiting:
            _, future = self._waiting[0]
            if future is not None and not future.done():
                break
            yield self._next()

    def rest(self) -> Iterator[Entry]:
        """Yield all messages that are left as soon as they are packed, and end."""
        while self._waiting:
            yield self._next()
        self._thread.shutdown()

    def _next(self) -> Entry:
        entry, future = self._waiting.popleft()
        return entry if future is None else entry._replace(data=future.result())


def packed(data: bytes, kind: Any) -> bytes:
    """Return a serialized message packed, or as it is if it is not made so that this helps."""
    try:
        layout = layout_in(data, kind)
        return data if layout is None else min(pack(data, layout), data, key=len)
    except Exception:  # rclpy raises whatever the type support throws; or memory is short
        return data


def layout_in(data: bytes, kind: Any) -> Layout | None:
    """Return the layout of a serialized message; None = it has no items that are alike."""
    message = deserialize_message(data, kind)
    if isinstance(message, Image):
        return layout_of(data, message.step // max(1, message.width), len(message.data),
                         IMAGE_TAILS)
    first = tuple((each.name, each.offset, each.datatype) for each in message.fields[:len(POINT)])
    return layout_of(data, message.point_step, len(message.data), CLOUD_TAILS,
                     len(POINT) if first == POINT else 0)
