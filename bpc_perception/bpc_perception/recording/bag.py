"""Read recordings: rosbag2 folders or files, whole or torn.

MCAP is the default of Jazzy; a writer can close its chunks at any time, and a torn file can be
read up to its last chunk. sqlite3 is the default of Humble.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
import heapq
from pathlib import Path
from typing import Any, NamedTuple

from bpc_perception.messages.types import MessageTypeError
from bpc_perception.recording.layouts import reader_of
from bpc_perception.recording.storage.files import kind_of, SQLITE, storage_files
from bpc_perception.recording.storage.packing import unpacked
from bpc_perception.recording.storage.raw_message import BagError, RawMessage
from bpc_perception.recording.storage.storage import open_storage, Storage


class BagMessage(NamedTuple):
    """A message of a recording.

    Attributes:
        topic: its recorded name.
        log_ns: time of recording [ns].
        message: the message itself.
    """

    topic: str
    log_ns: int
    message: Any


class Bag:
    """A recording to read.

    Attributes:
        path: the folder or file; the folder of a print stands for all of its recordings.
        files: the storage files, in the order of recording.
        topics: name of each topic to its type, such as ``sensor_msgs/msg/Image``.
        others: topic to the one that is to be read in its place.
    """

    def __init__(self, path: str | Path, others: Mapping[str, str] | None = None) -> None:
        """Open a recording. Raises BagError when there is none, or it has no messages."""
        self.path = Path(path)
        self.others = dict(others or {})
        self.files = storage_files(self.path)
        storages = [open_storage(file) for file in self.files]
        counts = [storage.topics() for storage in storages]
        # A recorder that was stopped may have begun a file into which nothing came any more.
        self._storage = [storage for storage, count in zip(storages, counts, strict=True) if count]
        self.topics = _most_frequent(counts)
        if not self.topics:
            kind = 'a sqlite3 bag' if kind_of(self.files[0]) == SQLITE else 'an MCAP file'
            raise BagError(f'{self.path}: expected {kind} with messages, found none'
                           '; is it the right recording?')

    def messages(self, topics: set[str], light: bool = False) -> Iterator[BagMessage]:
        """Yield the messages of these topics in the order of recording. Raises BagError.

        Light ones are made sooner: they have the same fields, but need not be of their class.
        """
        for raw in _in_time(self._storage, topics):
            if raw.type_name != self.topics[raw.topic]:
                continue  # of another type on the same topic
            try:
                message = reader_of(raw.channel, light)(unpacked(raw.data))
            except (BagError, MessageTypeError) as error:
                raise BagError(f'{self.path}: {error}') from error
            except Exception as error:  # rclpy raises whatever the type support throws
                raise BagError(f'{self.path}: expected a {raw.type_name} on {raw.topic}, '
                               f'found {len(raw.data)} other bytes; was it recorded with another '
                               'version of that message?') from error
            yield BagMessage(raw.topic, raw.log_ns, message)

    def count(self, topic: str) -> int | None:
        """Return the number of messages of a topic; None when a file does not state it."""
        counts = [storage.count(topic) for storage in self._storage]
        return None if None in counts else sum(count or 0 for count in counts)

    def span(self) -> tuple[int, int]:
        """Return the times of the first and the last message [ns]. Raises BagError for none."""
        spans = [storage.span() for storage in self._storage]
        return min(start for start, _ in spans), max(end for _, end in spans)


def _most_frequent(counted: Iterable[dict[tuple[str, str], int]]) -> dict[str, str]:
    """Return each topic with the type that most of its messages have."""
    total: Counter[tuple[str, str]] = Counter()
    for counts in counted:
        total.update(counts)
    return {topic: max((number, kind) for (other, kind), number in total.items()
                       if other == topic)[1] for topic, _ in total}


def _in_time(storages: list[Storage], topics: set[str]) -> Iterator[RawMessage]:
    """Yield the messages of files in the order of recording; spans of files may overlap."""
    group: list[Storage] = []
    end = 0
    for storage in storages:
        start, last = storage.span() if len(storages) > 1 else (0, 0)
        if group and not start <= end:
            yield from _merged(group, topics)
            group = []
        group.append(storage)
        end = max(end, last)
    yield from _merged(group, topics)


def _merged(storages: list[Storage], topics: set[str]) -> Iterator[RawMessage]:
    return heapq.merge(*(storage.messages(topics) for storage in storages),
                       key=lambda message: message.log_ns)
