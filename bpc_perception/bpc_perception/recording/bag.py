"""Read recordings: rosbag2 folders or files, whole or torn.

MCAP, the default of Jazzy, is read with the ``mcap`` package: a writer can close its chunks at any
time, and a torn file can be read up to its last chunk. sqlite3 bags, the default of Humble, are
read with ``rosbags``.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from rclpy.serialization import deserialize_message
from rosbags.rosbag2 import Reader as SqliteReader

from bpc_perception.messages.types import message_type
from bpc_perception.recording import mcap_file
from bpc_perception.recording.mcap_file import RawMessage
from bpc_perception.recording.print_folder import recordings_in


class BagError(ValueError):
    """A recording is not what was expected; the message names both."""


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
    """

    def __init__(self, path: str | Path) -> None:
        """Open a recording. Raises BagError when there is none, or it has no messages."""
        self.path = Path(path)
        self.files = _storage_files(self.path)
        self._storage: list[_Storage] = [
            _SqliteStorage(file) if file.suffix == '.db3' else _McapStorage(file)
            for file in self.files]
        self.topics: dict[str, str] = {}
        for storage in self._storage:
            self.topics.update(storage.topics())

    def messages(self, topics: set[str]) -> Iterator[BagMessage]:
        """Yield the messages of these topics in the order of recording. Raises BagError."""
        for storage in self._storage:
            for raw in storage.messages(topics):
                try:
                    message = deserialize_message(raw.data, message_type(raw.type_name))
                except Exception as error:  # rclpy raises whatever the type support throws
                    raise BagError(f'{self.path}: expected a {raw.type_name} on {raw.topic}, '
                                   f'found {len(raw.data)} other bytes') from error
                yield BagMessage(raw.topic, raw.log_ns, message)

    def count(self, topic: str) -> int | None:
        """Return the number of messages of a topic; None when a file does not state it."""
        counts = [storage.count(topic) for storage in self._storage]
        return None if None in counts else sum(count or 0 for count in counts)

    def span(self) -> tuple[int, int]:
        """Return the times of the first and the last message [ns]. Raises BagError for none."""
        spans = [storage.span() for storage in self._storage]
        return min(start for start, _ in spans), max(end for _, end in spans)


def _storage_files(path: Path) -> list[Path]:
    if path.is_file() and path.suffix in ('.mcap', '.db3'):
        return [path]
    if not path.exists():
        raise BagError(f'{path}: expected a bag, found nothing there')
    if recordings := recordings_in(path):  # more than one after a crash
        return [file for recording in recordings for file in _storage_files(recording)]
    files = sorted(path.glob('*.mcap'), key=lambda file: (len(file.name), file.name))  # 2, 10
    files += sorted(path.glob('*.db3'))[:1]  # its reader reads all others of the bag, too
    if not files:
        raise BagError(f'{path}: expected a rosbag2 folder or an .mcap or .db3 file, '
                       'found neither')
    return files


class _Storage(Protocol):
    """A storage file of a recording. All methods raise BagError."""

    def topics(self) -> dict[str, str]:
        """Return the name of each topic with its type."""

    def messages(self, topics: set[str] | None = None) -> Iterator[RawMessage]:
        """Yield the messages of these topics, or all, in the order of recording."""

    def count(self, topic: str) -> int | None:
        """Return the number of messages of a topic; None when the file does not state it."""

    def span(self) -> tuple[int, int]:
        """Return the times of the first and the last message [ns]."""


class _McapStorage:
    """An MCAP file. Its summary is missing when the file is torn; then messages are counted."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def topics(self) -> dict[str, str]:
        summary = mcap_file.summary(self._file)
        if summary is not None and summary.channels and all(
                channel.schema_id in summary.schemas for channel in summary.channels.values()):
            return {channel.topic: summary.schemas[channel.schema_id].name
                    for channel in summary.channels.values()}
        topics = {message.topic: message.type_name for message in self.messages()}
        if not topics:
            raise BagError(f'{self._file}: expected an MCAP file with messages, found none')
        return topics

    def messages(self, topics: set[str] | None = None) -> Iterator[RawMessage]:
        for message in mcap_file.messages(self._file):
            if topics is None or message.topic in topics:
                yield message

    def count(self, topic: str) -> int | None:
        summary = mcap_file.summary(self._file)
        if summary is None or summary.statistics is None:
            return None
        return sum(summary.statistics.channel_message_counts.get(number, 0)
                   for number, channel in summary.channels.items() if channel.topic == topic)

    def span(self) -> tuple[int, int]:
        summary = mcap_file.summary(self._file)
        if summary is not None and summary.statistics is not None:
            return summary.statistics.message_start_time, summary.statistics.message_end_time
        return _span_of_messages(self._file, self.messages())


class _SqliteStorage:
    """A sqlite3 bag. It cannot be read without its metadata.yaml."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def topics(self) -> dict[str, str]:
        with self._open() as reader:
            return {connection.topic: connection.msgtype for connection in reader.connections}

    def messages(self, topics: set[str] | None = None) -> Iterator[RawMessage]:
        with self._open() as reader:
            chosen = [connection for connection in reader.connections
                      if topics is None or connection.topic in topics]
            for connection, log_ns, data in reader.messages(chosen):
                yield RawMessage(connection.topic, connection.msgtype, b'', log_ns, bytes(data))

    def count(self, topic: str) -> int | None:
        with self._open() as reader:
            return sum(connection.msgcount for connection in reader.connections
                       if connection.topic == topic)

    def span(self) -> tuple[int, int]:
        return _span_of_messages(self._file, self.messages())

    @contextmanager
    def _open(self) -> Iterator[SqliteReader]:
        try:
            with SqliteReader(self._file.parent) as reader:
                yield reader
        except Exception as error:  # of the reader, or of its database
            raise BagError(f'{self._file.parent}: expected a complete sqlite3 bag with its '
                           f'metadata.yaml, found: {error}') from error


def _span_of_messages(file: Path, messages: Iterator[RawMessage]) -> tuple[int, int]:
    times = [message.log_ns for message in messages]
    if not times:
        raise BagError(f'{file}: expected messages, found none')
    return min(times), max(times)
