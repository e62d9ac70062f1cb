"""Read what is whole in MCAP files that may be torn, damaged or made to harm.

A length in a damaged file may be anything. So that it does not take all memory, the ``mcap``
package can read no more than the size of the file, and no chunk is unpacked that states more than
``LARGEST_CHUNK_BYTES``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Set
from dataclasses import replace
import heapq
import logging
import os
from pathlib import Path
from typing import Any, BinaryIO

import lz4.frame
from mcap.data_stream import ReadDataStream
from mcap.reader import make_reader, Summary
from mcap.records import (
    Attachment,
    Channel as ChannelRecord,
    Chunk,
    ChunkIndex,
    McapRecord,
    Message,
    MessageIndex,
    Metadata,
    Schema,
)
from mcap.stream_reader import breakup_chunk, StreamReader
import zstandard

from bpc_perception.recording.storage.raw_message import Channel, RawMessage

logger = logging.getLogger(__name__)
LARGEST_CHUNK_BYTES = 1 << 30  # unpacked; fifteen captures of the largest camera
RECORD_HEAD_BYTES = 9  # opcode and length
SET_BACK_NS = 5 * 10**9  # by which a topic goes back in time only if the clock did
# By the name of the compression: packed data and the most bytes to unpack, to unpacked data.
DECOMPRESSORS: dict[str, Callable[[bytes, int], bytes]] = {
    '': lambda data, _: data,
    'lz4': lambda data, most: lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=most),
    'zstd': lambda data, most: zstandard.ZstdDecompressor().stream_reader(data).read(most)}


class BoundedFile:
    """A file that refuses to read more than it has, before memory is taken for it."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._size = os.fstat(stream.fileno()).st_size

    def read(self, length: int = -1) -> bytes:
        """Read exactly ``length`` bytes. Raises EOFError."""
        left = self._size - self._stream.tell()
        if length > left:
            raise EOFError(f'expected {length} bytes, found {left}')
        return self._stream.read(length)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Set the position."""
        return self._stream.seek(offset, whence)

    def tell(self) -> int:
        """Return the position."""
        return self._stream.tell()

    def seekable(self) -> bool:
        """Return that the position can be set."""
        return True


def bounded(stream: BinaryIO) -> Any:
    """Wrap a file for the package, which asks for an IO[bytes] but uses no more than this."""
    return BoundedFile(stream)


def summary(file: Path) -> Summary | None:
    """Return the summary at the end of a file; None when the file is torn."""
    try:
        with file.open('rb') as stream:
            return make_reader(bounded(stream)).get_summary()
    except Exception:  # as in _records
        return None


def metadata(file: Path, name: str) -> dict[str, str]:
    """Return the first metadata record of this name; empty when there is none."""
    return next((record.metadata for record in _records(file)
                 if isinstance(record, Metadata) and record.name == name), {})


def beside_messages(file: Path) -> Iterator[Attachment | Metadata]:
    """Yield what lies beside the messages: files that were attached, and records of metadata."""
    return (record for record in _records(file) if isinstance(record, Attachment | Metadata))


def messages(file: Path) -> Iterator[RawMessage]:
    """Yield all whole messages in the order of the file.

    A damaged chunk is left out, and everything behind it if its end cannot be found. Both are
    logged.
    """
    schemas: dict[int, Schema] = {}
    records: dict[int, ChannelRecord] = {}
    channels: dict[int, Channel] = {}
    for record in _records(file):
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, ChannelRecord):
            records[record.id] = record
        elif isinstance(record, Message):
            number = record.channel_id
            if number not in channels and number in records:
                if (schema := schemas.get(records[number].schema_id)) is None:
                    continue  # it was in a damaged chunk
                channels[number] = _channel(records[number], schema)
            if number in channels:
                yield _raw(channels[number], record)


def messages_in_time(file: Path, topics: Set[str] | None = None) -> Iterator[RawMessage]:
    """Yield the messages of these topics, or all, in the order in which they were recorded.

    A writer may have left them in another: topic after topic, or of several writers. Where the
    index does not say, since the file is torn or has no chunks, or where the recorder's clock was
    set back, the order of the file counts.
    """
    found = summary(file)
    if (found is None or not found.chunk_indexes or _was_set_back(file, found)
            or any(channel.schema_id not in found.schemas
                   for channel in found.channels.values())):
        yield from (message for message in messages(file)
                    if topics is None or message.topic in topics)
        return
    wanted = {number: _channel(channel, found.schemas[channel.schema_id])
              for number, channel in found.channels.items()
              if topics is None or channel.topic in topics}
    waiting: list[tuple[int, int, int, Message | None]] = [
        (index.message_start_time, index.chunk_start_offset, -1, None)
        for index in found.chunk_indexes if wanted.keys() & index.message_index_offsets.keys()]
    heapq.heapify(waiting)
    with file.open('rb') as stream:
        while waiting:
            _, offset, _, message = heapq.heappop(waiting)
            if message is not None:
                yield _raw(wanted[message.channel_id], message)
                continue
            for place, (time, record) in enumerate(_timed(_chunk_at(file, stream, offset))):
                if record.channel_id in wanted:
                    heapq.heappush(waiting, (time, offset, place, record))


def _was_set_back(file: Path, found: Summary) -> bool:
    """Return whether the recorder's clock was set back: a topic goes on far before it was."""
    latest: dict[int, ChunkIndex] = {}
    for index in sorted(found.chunk_indexes, key=lambda index: index.chunk_start_offset):
        for channel in index.message_index_offsets:
            before = latest.get(channel)
            # What the chunk before ends with may be of another topic: its own index tells.
            if (before is not None
                    and index.message_end_time < before.message_end_time - SET_BACK_NS
                    and index.message_end_time < _last_time(file, before, channel) - SET_BACK_NS):
                return True
            latest[channel] = index
    return False


def _last_time(file: Path, index: ChunkIndex, channel: int) -> int:
    """Return the time of the last message of a channel in a chunk; 0 if its index is damaged."""
    try:
        with file.open('rb') as stream:
            stream.seek(index.message_index_offsets[channel] + RECORD_HEAD_BYTES)
            records = MessageIndex.read(ReadDataStream(bounded(stream))).records
            return max((time for time, _ in records), default=0)
    except Exception:  # as in _records
        return 0


def _timed(records: Iterable[McapRecord]) -> Iterator[tuple[int, Message]]:
    """Yield the messages of a chunk, each with its time; it stays where a clock was set back."""
    latest: dict[int, int] = {}
    held = 0
    for record in records:
        if isinstance(record, Message):
            before = latest.get(record.channel_id, 0)
            if record.log_time < before - SET_BACK_NS:
                held = max(held, before)
            latest[record.channel_id] = max(before, record.log_time)
            yield max(record.log_time, held), record


def _chunk_at(file: Path, stream: BinaryIO, offset: int) -> list[McapRecord]:
    """Return the records of the chunk at an offset of a file; none if it is damaged."""
    try:
        stream.seek(offset + RECORD_HEAD_BYTES)
        chunk = Chunk.read(ReadDataStream(bounded(stream)))
    except Exception as error:  # as in _records
        logger.warning('%s: left out a damaged chunk (%s)', file, type(error).__name__)
        return []
    return _unpacked(file, chunk)


def _channel(channel: ChannelRecord, schema: Schema) -> Channel:
    return Channel(channel.topic, full_name(schema.name), schema.data, schema.encoding,
                   channel.message_encoding, tuple(channel.metadata.items()))


def _raw(channel: Channel, record: Message) -> RawMessage:
    return RawMessage(channel, record.log_time, record.data, record.publish_time, record.sequence)


def full_name(type_name: str) -> str:
    """Return a type such as ``sensor_msgs/Image`` as ``sensor_msgs/msg/Image``."""
    package, _, name = type_name.partition('/')
    return f'{package}/msg/{name}' if name and '/' not in name else type_name


def _records(file: Path) -> Iterator[McapRecord]:
    """Yield all records, with those of a chunk in place of the chunk."""
    # On damaged bytes the package lets through what its parts raise: struct.error, MemoryError,
    # UnicodeDecodeError, KeyError, the errors of the decompressors and more.
    with file.open('rb') as stream:
        reader = StreamReader(bounded(stream), emit_chunks=True, record_size_limit=None)
        try:
            for record in reader.records:
                if isinstance(record, Chunk):
                    yield from _unpacked(file, record)
                else:
                    yield record
        except Exception as error:
            logger.warning('%s: torn, read up to the damage (%s)', file, type(error).__name__)


def _unpacked(file: Path, chunk: Chunk) -> list[McapRecord]:
    """Return the records of a chunk; none if it is damaged."""
    try:
        data = _decompressed(chunk)
        return breakup_chunk(replace(chunk, compression='', data=data), validate_crc=True)
    except Exception as error:
        logger.warning('%s: left out a damaged chunk (%s)', file, type(error).__name__)
        return []


def _decompressed(chunk: Chunk) -> bytes:
    size = chunk.uncompressed_size
    if size > LARGEST_CHUNK_BYTES:
        raise ValueError(f'expected at most {LARGEST_CHUNK_BYTES} bytes, found {size}')
    if chunk.compression not in DECOMPRESSORS:
        raise ValueError(f'expected lz4 or zstd, found {chunk.compression!r}')
    # One byte more than stated, if it can be read, tells that there is more.
    data = DECOMPRESSORS[chunk.compression](chunk.data, size + 1)
    if len(data) != size:
        raise ValueError(f'expected {size} bytes, found others')
    return data
