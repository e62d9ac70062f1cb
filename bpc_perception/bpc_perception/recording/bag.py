"""Recordings to read: rosbag2 folders or files, whole or torn.

Written as MCAP, the default of Jazzy, with the ``mcap`` package, since its chunks can be
closed at will and a torn file read up to its last chunk. sqlite3 bags, the default of Humble,
are read with ``rosbags``.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rclpy.serialization import deserialize_message
from rosbags.rosbag2 import Reader as SqliteReader

from bpc_perception.messages.types import message_type
from bpc_perception.recording import mcap_file


class BagError(ValueError):
    """A recording is not what was expected; the message names both."""


class Bag:
    """A recording to read.

    Attributes:
        path: the folder or file.
        files: of the storage, in the order of recording.
        topics: name of each topic to its type, such as ``sensor_msgs/msg/Image``.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.files = _storage_files(self.path)
        self.topics: dict[str, str] = {}
        for file in self.files:
            self.topics.update(_sqlite_topics(file) if file.suffix == '.db3'
                               else _mcap_topics(file))

    def messages(self, topics: set[str]) -> Iterator[tuple[str, int, Any]]:
        """Yield (topic, time of recording [ns], message) in the order of recording."""
        for file in self.files:
            for topic, type_name, log_ns, data in _raw_messages(file, topics):
                try:
                    message = deserialize_message(data, message_type(type_name))
                except Exception as error:  # rclpy raises whatever the type support throws
                    raise BagError(f'{self.path}: expected a {type_name} on {topic}, '
                                   f'found {len(data)} other bytes') from error
                yield topic, log_ns, message

    def count(self, topic: str) -> int | None:
        """How many messages of a topic there are, where the recording says so."""
        counts = [_count(file, topic) for file in self.files]
        return None if None in counts else sum(count or 0 for count in counts)

    def span(self) -> tuple[int, int]:
        """Times of the first and the last message [ns]. Raises BagError where there is none."""
        spans = [_span(file, set(self.topics)) for file in self.files]
        return min(start for start, _ in spans), max(end for _, end in spans)


def _storage_files(path: Path) -> list[Path]:
    if path.is_file() and path.suffix in ('.mcap', '.db3'):
        return [path]
    if not path.exists():
        raise BagError(f'{path}: expected a bag, found nothing there')
    files = sorted(path.glob('*.mcap'), key=lambda file: (len(file.name), file.name))  # 2, 10
    files += sorted(path.glob('*.db3'))[:1]  # one is read with all others of its bag
    if not files:
        raise BagError(f'{path}: expected a rosbag2 folder or an .mcap or .db3 file, '
                       'found neither')
    return files


def _raw_messages(file: Path, topics: set[str]) -> Iterator[tuple[str, str, int, bytes]]:
    read = _sqlite_messages if file.suffix == '.db3' else _mcap_messages
    return read(file, topics)


def _span(file: Path, topics: set[str]) -> tuple[int, int]:
    summary = mcap_file.summary(file) if file.suffix == '.mcap' else None
    if summary is not None and summary.statistics is not None:
        return summary.statistics.message_start_time, summary.statistics.message_end_time
    times = [log_ns for _, _, log_ns, _ in _raw_messages(file, topics)]
    if not times:
        raise BagError(f'{file}: expected messages, found none')
    return min(times), max(times)


def _count(file: Path, topic: str) -> int | None:
    if file.suffix == '.db3':
        with _open_sqlite(file) as reader:
            return sum(connection.msgcount for connection in reader.connections
                       if connection.topic == topic)
    summary = mcap_file.summary(file)
    if summary is None or summary.statistics is None:
        return None
    return sum(summary.statistics.channel_message_counts.get(number, 0)
               for number, channel in summary.channels.items() if channel.topic == topic)


def _mcap_topics(file: Path) -> dict[str, str]:
    summary = mcap_file.summary(file)
    if summary is not None and summary.channels and all(
            channel.schema_id in summary.schemas for channel in summary.channels.values()):
        return {channel.topic: summary.schemas[channel.schema_id].name
                for channel in summary.channels.values()}
    topics = {message.topic: message.type_name for message in mcap_file.messages(file)}
    if not topics:
        raise BagError(f'{file}: expected an MCAP file with messages, found none')
    return topics


def _mcap_messages(file: Path, topics: set[str]) -> Iterator[tuple[str, str, int, bytes]]:
    for message in mcap_file.messages(file):
        if message.topic in topics:
            yield message.topic, message.type_name, message.log_ns, message.data


def _sqlite_topics(file: Path) -> dict[str, str]:
    with _open_sqlite(file) as reader:
        return {connection.topic: connection.msgtype for connection in reader.connections}


def _sqlite_messages(file: Path, topics: set[str]) -> Iterator[tuple[str, str, int, bytes]]:
    with _open_sqlite(file) as reader:
        chosen = [connection for connection in reader.connections if connection.topic in topics]
        for connection, log_ns, data in reader.messages(chosen):
            yield connection.topic, connection.msgtype, log_ns, bytes(data)


@contextmanager
def _open_sqlite(file: Path) -> Iterator[SqliteReader]:
    try:
        with SqliteReader(file.parent) as reader:
            yield reader
    except Exception as error:  # the reader's own, or those of its database
        raise BagError(f'{file.parent}: expected a complete sqlite3 bag with its metadata.yaml, '
                       f'found: {error}') from error
