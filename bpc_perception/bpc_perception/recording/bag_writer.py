"""Write recordings so that nothing is lost: a rosbag2 folder with one MCAP file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Set
from contextlib import contextmanager, suppress
import os
from pathlib import Path
from types import TracebackType
from typing import Any

from mcap.records import Attachment, Metadata
from mcap.well_known import Profile
from mcap.writer import CompressionType, Writer
from rclpy.serialization import serialize_message
import yaml

from bpc_perception.messages.types import message_definition
from bpc_perception.recording.storage.raw_message import (
    BagError,
    CDR,
    Channel,
    PACKED,
    RawMessage,
)

# A killed recorder loses one chunk, so chunks are small. A larger message gets its own chunk.
CHUNK_SIZE_BYTES = 64 * 1024
QOS = 'offered_qos_profiles'  # name of what a channel says of it, as rosbag2 writes it


def begin_recording(path: Path, types: Mapping[str, str], beside: Mapping[str, bytes],
                    packed: Set[str] = frozenset()) -> BagWriter:
    """Begin a recording of topics of these types, with further files beside it, by name.

    Messages of ``packed`` topics may be packed. Raises OSError, and BagError if there is
    something already.
    """
    writer = BagWriter(path)
    try:
        for topic, kind in types.items():
            writer.add_topic(topic, kind, packed=topic in packed)
        for name, content in beside.items():
            (path / name).write_bytes(content)
    except BaseException:
        writer.close()
        raise
    return writer


class BagWriter:
    """A new rosbag2 folder with one MCAP file; a context manager.

    The file is readable up to the last ``flush`` even if it is never closed. A message larger
    than a chunk is flushed at once, with all messages before it.

    After an OSError of ``write`` or ``flush``, for instance on a full disk, the file ends torn. No
    reader could read anything behind half a record, so nothing more is written.
    """

    def __init__(self, path: str | Path, compress: bool = False,
                 about: Mapping[str, Any] | None = None) -> None:
        """Begin a bag; metadata.yaml gets what ``about`` says. Raises BagError, OSError."""
        self.path = Path(path)
        if self.path.exists():
            raise BagError(f'{path}: expected a new bag, found that it exists'
                           '; name another, or move it away')
        self.path.mkdir(parents=True)
        self._file = self.path / f'{self.path.name}_0.mcap'
        compression = CompressionType.ZSTD if compress else CompressionType.NONE
        self._stream = self._file.open('wb')
        self._writer = Writer(self._stream, chunk_size=CHUNK_SIZE_BYTES, compression=compression)
        self._torn = False
        with self._writing():
            self._writer.start(Profile.ROS2, library='bpc')
        self._about = dict(about or {})
        self._topics: dict[str, Channel] = {}
        self._channels: dict[Channel, int] = {}
        self._schemas: dict[tuple[str, str, bytes], int] = {}
        self._counts: Counter[Channel] = Counter()
        self._first_ns: int | None = None
        self._last_ns = 0

    def add_topic(self, topic: str, type_name: str, packed: bool = False) -> None:
        """Announce a topic of an installed type such as ``sensor_msgs/msg/Image``.

        Its messages may be ``packed``, see ``planes``.
        """
        self._topics[topic] = Channel(topic, type_name, message_definition(type_name).encode(),
                                      encoding=PACKED if packed else CDR, metadata=((QOS, ''),))
        self.add_channel(self._topics[topic])

    def add_channel(self, channel: Channel) -> None:
        """Announce a topic of a type that need not be installed."""
        schema = channel.type_name, channel.definition_encoding, channel.definition
        if schema not in self._schemas:
            self._schemas[schema] = self._writer.register_schema(*schema)
        self._channels[channel] = self._writer.register_channel(
            channel.topic, channel.encoding, self._schemas[schema], dict(channel.metadata))
        self._counts[channel] = 0

    def write(self, topic: str, log_ns: int, message: Any) -> None:
        """Append a message, which may be serialized already, recorded at ``log_ns`` [ns]."""
        data = message if isinstance(message, bytes) else serialize_message(message)
        channel = self._topics[topic]
        self.copy(RawMessage(channel, log_ns, data, log_ns, self._counts[channel]))

    def copy(self, raw: RawMessage) -> None:
        """Append a message of another recording, with all that is known of it."""
        if raw.channel not in self._channels:
            self.add_channel(raw.channel)
        large = len(raw.data) > CHUNK_SIZE_BYTES
        with self._writing():
            if large:  # if writing it fails, the messages before it are on disk already
                self._writer.flush()
            self._writer.add_message(
                self._channels[raw.channel], log_time=raw.log_ns, publish_time=raw.publish_ns,
                data=raw.data, sequence=raw.sequence)
            if large:
                self._writer.flush()
        self._counts[raw.channel] += 1
        self._first_ns = raw.log_ns if self._first_ns is None else min(self._first_ns, raw.log_ns)
        self._last_ns = max(self._last_ns, raw.log_ns)

    def copy_beside(self, record: Attachment | Metadata) -> None:
        """Append what lies in another recording beside its messages."""
        with self._writing():
            if isinstance(record, Metadata):
                self._writer.add_metadata(record.name, record.metadata)
            else:
                self._writer.add_attachment(record.create_time, record.log_time, record.name,
                                            record.media_type, record.data)

    @property
    def written(self) -> tuple[dict[str, int], int]:
        """Messages written by topic, and the size of the file [bytes], even if it was moved."""
        counts = {channel.topic: count for channel, count in self._counts.items()}
        return counts, os.fstat(self._stream.fileno()).st_size

    @property
    def in_place(self) -> bool:
        """Whether the file is still found under the name under which it was begun."""
        with suppress(OSError):
            return os.path.samestat(self._file.stat(), os.fstat(self._stream.fileno()))
        return False

    def flush(self) -> None:
        """Hand everything written so far to the operating system; all of it is readable then."""
        with self._writing():
            self._writer.flush()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        if self._torn:
            raise OSError(f'{self._file}: expected a file to go on with, found it torn'
                          '; begin another recording')
        try:
            yield
        except OSError:
            self._torn = True
            raise

    def close(self) -> None:
        """Complete the file and describe it in metadata.yaml, unless it is torn or complete."""
        if self._stream.closed:
            return
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
                    'name': channel.topic, 'type': channel.type_name,
                    'serialization_format': channel.encoding,
                    'offered_qos_profiles': _qos_of(channel), 'type_description_hash': ''},
                 'message_count': count} for channel, count in self._counts.items()],
            'compression_format': '', 'compression_mode': '',
            'files': [{'path': self._file.name, 'starting_time': start, 'duration': duration,
                       'message_count': count}],
            'custom_data': None, 'ros_distro': 'jazzy', **self._about}
        temporary = self.path / 'metadata.yaml.tmp'
        temporary.write_text(yaml.safe_dump({'rosbag2_bagfile_information': information}))
        temporary.replace(self.path / 'metadata.yaml')

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()


def _qos_of(channel: Channel) -> list[Any]:
    """Return the QoS profiles of a channel; none where Jazzy would not know their words."""
    with suppress(yaml.YAMLError):
        profiles = yaml.safe_load(dict(channel.metadata).get(QOS, ''))
        if isinstance(profiles, list) and all(
                isinstance(profile, dict) and isinstance(profile.get('history'), str)
                for profile in profiles):
            return profiles
    return []
