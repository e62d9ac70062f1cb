"""Recordings: rosbag2 folders or files, read whole or torn, and written so that nothing is lost.

Written as MCAP, the default of Jazzy, with the ``mcap`` package, since its chunks can be
closed at will and a torn file read up to its last chunk. sqlite3 bags, the default of Humble,
are read with ``rosbags``.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib import import_module
import os
from pathlib import Path
from types import TracebackType
from typing import Any

from ament_index_python.packages import get_package_share_directory
from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import CompressionType, Writer
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.rosbag2 import Reader as SqliteReader
import yaml

from bpc_perception import mcap_file

# Small chunks bound what a killed recorder loses; a larger message gets a chunk of its own.
CHUNK_SIZE = 64 * 1024


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


class BagWriter:
    """A new rosbag2 folder with one MCAP file; a context manager.

    Readable up to the last ``flush`` even if it is never closed. A message larger than a chunk
    is flushed at once, with all before it.

    After an OSError of ``write`` or ``flush``, such as that of a full disk, the file ends torn:
    what comes behind half a record would be lost to every reader, so nothing is written any more.
    """

    def __init__(self, path: str | Path, compress: bool = False) -> None:
        self.path = Path(path)
        if self.path.exists():
            raise BagError(f'{path}: expected a new bag, found that it exists')
        self.path.mkdir(parents=True)
        self._file = self.path / f'{self.path.name}_0.mcap'
        compression = CompressionType.ZSTD if compress else CompressionType.NONE
        self._stream = self._file.open('wb')
        self._writer = Writer(self._stream, chunk_size=CHUNK_SIZE, compression=compression)
        self._torn = False
        with self._writing():
            self._writer.start(Profile.ROS2, library='bpc')
        self._channels: dict[str, int] = {}
        self._types: dict[str, str] = {}
        self._schemas: dict[str, int] = {}
        self._counts: dict[str, int] = {}
        self._first_ns: int | None = None
        self._last_ns = 0

    def add_topic(self, topic: str, type_name: str, definition: bytes = b'') -> None:
        """Announce a topic of a type such as ``sensor_msgs/msg/Image``.

        The definition is that of the installed type, unless it is given.
        """
        if type_name not in self._schemas:
            self._schemas[type_name] = self._writer.register_schema(
                type_name, SchemaEncoding.ROS2,
                definition or message_definition(type_name).encode())
        self._channels[topic] = self._writer.register_channel(
            topic, MessageEncoding.CDR, self._schemas[type_name],
            {'offered_qos_profiles': ''})
        self._types[topic] = type_name
        self._counts[topic] = 0

    def write(self, topic: str, log_ns: int, message: Any) -> None:
        """Append a message, or one that is serialized already, recorded at this time [ns]."""
        data = message if isinstance(message, bytes) else serialize_message(message)
        large = len(data) > CHUNK_SIZE
        with self._writing():
            if large:  # or else what waits would be lost with it if it is torn
                self._writer.flush()
            self._writer.add_message(self._channels[topic], log_time=log_ns, publish_time=log_ns,
                                     data=data, sequence=self._counts[topic])
            if large:
                self._writer.flush()
        self._counts[topic] += 1
        self._first_ns = log_ns if self._first_ns is None else min(self._first_ns, log_ns)
        self._last_ns = max(self._last_ns, log_ns)

    @property
    def written(self) -> tuple[dict[str, int], int]:
        """Messages written by topic, and the size of the file [bytes], wherever it is by now."""
        return dict(self._counts), os.fstat(self._stream.fileno()).st_size

    @property
    def in_place(self) -> bool:
        """Whether what is written is found by the name under which it was begun."""
        with suppress(OSError):
            return os.path.samestat(self._file.stat(), os.fstat(self._stream.fileno()))
        return False

    def flush(self) -> None:
        """Hand everything written so far to the operating system, readable as it is."""
        with self._writing():
            self._writer.flush()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        if self._torn:
            raise OSError(f'{self._file}: expected a file to go on with, found it torn')
        try:
            yield
        except OSError:
            self._torn = True
            raise

    def close(self) -> None:
        """Complete the file and describe it in metadata.yaml, unless it is torn."""
        if self._torn:
            with suppress(OSError):
                self._stream.close()
            return
        with self._writing():
            self._writer.finish()
            self._stream.close()
        self._describe()

    def _describe(self) -> None:
        start = {'nanoseconds_since_epoch': self._first_ns or 0}
        duration = {'nanoseconds': self._last_ns - (self._first_ns or 0)}
        count = sum(self._counts.values())
        information = {
            'version': 9, 'storage_identifier': 'mcap',
            'relative_file_paths': [self._file.name], 'duration': duration,
            'starting_time': start, 'message_count': count,
            'topics_with_message_count': [
                {'topic_metadata': {
                    'name': topic, 'type': self._types[topic], 'serialization_format': 'cdr',
                    'offered_qos_profiles': [], 'type_description_hash': ''},
                 'message_count': count} for topic, count in self._counts.items()],
            'compression_format': '', 'compression_mode': '',
            'files': [{'path': self._file.name, 'starting_time': start, 'duration': duration,
                       'message_count': count}],
            'custom_data': None, 'ros_distro': 'jazzy'}
        temporary = self.path / 'metadata.yaml.tmp'
        temporary.write_text(yaml.safe_dump({'rosbag2_bagfile_information': information}))
        temporary.replace(self.path / 'metadata.yaml')

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()


@cache
def message_type(type_name: str) -> Any:
    """The Python class of a message type such as ``sensor_msgs/msg/Image``."""
    try:
        package, kind, name = type_name.split('/')
        return getattr(import_module(f'{package}.{kind}'), name)
    except (ValueError, ImportError, AttributeError) as error:
        raise BagError(f'message type: expected one that is installed, '
                       f'found {type_name}') from error


@cache
def message_definition(type_name: str) -> str:
    """The text of a message type and of all it uses, as rosbag2 stores it."""
    texts: dict[str, str] = {}
    pending = [type_name.replace('/msg/', '/')]
    while pending:
        name = pending.pop(0)
        if name in texts:
            continue
        try:
            package, short = name.split('/')
            source = Path(get_package_share_directory(package)) / 'msg' / f'{short}.msg'
            texts[name] = source.read_text(encoding='utf-8')
        except (ValueError, LookupError, OSError) as error:
            raise BagError(f'message type: expected one that is installed, '
                           f'found {type_name}') from error
        for line in texts[name].splitlines():
            field = line.split('#')[0].split()
            base = field[0].split('[')[0] if len(field) >= 2 else ''
            if '/' in base:
                pending.append(base.replace('/msg/', '/'))
            elif base[:1].isupper():
                pending.append(f'{package}/{base}')
    first, *others = texts
    separator = '=' * 80
    return texts[first] + ''.join(
        f'\n{separator}\nMSG: {name}\n{texts[name]}' for name in others)


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
