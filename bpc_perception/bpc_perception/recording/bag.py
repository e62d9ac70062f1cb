"""Read recordings: rosbag2 folders or files, whole or torn.

MCAP, the default of Jazzy, is read with the ``mcap`` package: a writer can close its chunks at any
time, and a torn file can be read up to its last chunk. sqlite3 bags, the default of Humble, are
read with ``rosbags``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
import heapq
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from rclpy.serialization import deserialize_message
from rosbags.rosbag2 import Reader as SqliteReader

from bpc_perception.files.yaml_file import FileError, read_yaml
from bpc_perception.messages.types import message_type
from bpc_perception.recording import mcap_file
from bpc_perception.recording.mcap_file import RawMessage
from bpc_perception.recording.print_folder import recordings_in

LARGEST_METADATA_BYTES = 10_000_000  # a thousand topics have one


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
        others: topic to the one that is to be read in its place.
    """

    def __init__(self, path: str | Path, others: Mapping[str, str] | None = None) -> None:
        """Open a recording. Raises BagError when there is none, or it has no messages."""
        self.path = Path(path)
        self.others = dict(others or {})
        self.files = _storage_files(self.path)
        storages: list[_Storage] = [
            _SqliteStorage(file) if file.suffix == '.db3' else _McapStorage(file)
            for file in self.files]
        counts = [storage.topics() for storage in storages]
        # A recorder that was stopped may have begun a file into which nothing came any more.
        self._storage = [storage for storage, count in zip(storages, counts, strict=True) if count]
        self.topics = _most_frequent(counts)
        if not self.topics:
            kind = 'a sqlite3 bag' if self.files[0].suffix == '.db3' else 'an MCAP file'
            raise BagError(f'{self.path}: expected {kind} with messages, found none'
                           '; is it the right recording?')

    def messages(self, topics: set[str]) -> Iterator[BagMessage]:
        """Yield the messages of these topics in the order of recording. Raises BagError."""
        for raw in _in_time(self._storage, topics):
            if raw.type_name != self.topics[raw.topic]:
                continue  # of another type on the same topic
            try:
                message = deserialize_message(raw.data, message_type(raw.type_name))
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


def _storage_files(path: Path) -> list[Path]:
    if path.is_file() and path.suffix in ('.mcap', '.db3'):
        listed = listed_files(path.parent)
        # The reader of sqlite3 files reads what is listed, whatever it is asked for.
        if path.suffix == '.db3' and listed and path.name not in {file.name for file in listed}:
            raise BagError(f'{path}: expected a file that metadata.yaml lists, found '
                           f'{", ".join(file.name for file in listed)} there; give it a folder '
                           'of its own with its metadata.yaml')
        return [path]
    if not path.exists():
        raise BagError(f'{path}: expected a bag, found nothing there'
                       '; name the folder or file of a recording')
    if recordings := recordings_in(path):  # more than one after a crash
        return [file for recording in recordings for file in _storage_files(recording)]
    files = listed_files(path)
    if not files:
        files = sorted(path.glob('*.mcap'), key=lambda file: (len(file.name), file.name))  # 2, 10
        files += path.glob('*.db3')
    # The reader of sqlite3 files reads all others of the bag, too.
    files = [file for file in files if file.suffix == '.mcap'] + [
        file for file in sorted(files) if file.suffix == '.db3'][:1]
    if not files:
        raise BagError(f'{path}: expected a rosbag2 folder or an .mcap or .db3 file, '
                       'found neither; name one of these')
    return files


def listed_files(path: Path) -> list[Path]:
    """Return the files that metadata.yaml lists, in its order, as far as they are there."""
    try:
        content = read_yaml(path / 'metadata.yaml', LARGEST_METADATA_BYTES, aliases=True)
        names = content['rosbag2_bagfile_information']['relative_file_paths']
        files = [path / Path(str(name)).name for name in names]
    except (FileError, LookupError, TypeError):
        return []
    return [file for file in files if file.suffix in ('.mcap', '.db3') and file.is_file()]


def _most_frequent(counted: Iterable[dict[tuple[str, str], int]]) -> dict[str, str]:
    """Return each topic with the type that most of its messages have."""
    total: Counter[tuple[str, str]] = Counter()
    for counts in counted:
        total.update(counts)
    return {topic: max((number, kind) for (other, kind), number in total.items()
                       if other == topic)[1] for topic, _ in total}


def _in_time(storages: list[_Storage], topics: set[str]) -> Iterator[RawMessage]:
    """Yield the messages of files in the order of recording; spans of files may overlap."""
    group: list[_Storage] = []
    end = 0
    for storage in storages:
        start, last = storage.span() if len(storages) > 1 else (0, 0)
        if group and not start <= end:
            yield from _merged(group, topics)
            group = []
        group.append(storage)
        end = max(end, last)
    yield from _merged(group, topics)


def _merged(storages: list[_Storage], topics: set[str]) -> Iterator[RawMessage]:
    return heapq.merge(*(storage.messages(topics) for storage in storages),
                       key=lambda message: message.log_ns)


class _Storage(Protocol):
    """A storage file of a recording. All methods raise BagError."""

    def topics(self) -> dict[tuple[str, str], int]:
        """Return each topic and type with the number of its messages; 1 if it is not stated."""

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

    def topics(self) -> dict[tuple[str, str], int]:
        summary = mcap_file.summary(self._file)
        if summary is not None and summary.statistics is not None and all(
                channel.schema_id in summary.schemas for channel in summary.channels.values()):
            counts = summary.statistics.channel_message_counts
            found: Counter[tuple[str, str]] = Counter()
            for number, channel in summary.channels.items():
                kind = mcap_file.full_name(summary.schemas[channel.schema_id].name)
                found[channel.topic, kind] += counts.get(number, 0)
            return dict(found)
        return dict(Counter((message.topic, message.type_name)
                            for message in mcap_file.messages(self._file)))

    def messages(self, topics: set[str] | None = None) -> Iterator[RawMessage]:
        return mcap_file.messages_in_time(self._file, topics)

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

    def topics(self) -> dict[tuple[str, str], int]:
        with self._open() as reader:
            return {(connection.topic, connection.msgtype): connection.msgcount
                    for connection in reader.connections}

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
                           f'metadata.yaml, found: {error}'
                           '; copy it with all its files, or make it anew with "ros2 '
                           'bag reindex"') from error


def _span_of_messages(file: Path, messages: Iterator[RawMessage]) -> tuple[int, int]:
    times = [message.log_ns for message in messages]
    if not times:
        raise BagError(f'{file}: expected messages, found none; is it the right file?')
    return min(times), max(times)
