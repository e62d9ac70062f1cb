"""Read what is whole in MCAP files that may be torn, damaged or made to harm.

A length in a damaged file may be anything. So that it does not take all memory, the ``mcap``
package can read no more than the size of the file, and no chunk is unpacked that states more than
``LARGEST_CHUNK_BYTES``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
import logging
import os
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import lz4.frame
from mcap.reader import make_reader, Summary
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import breakup_chunk, StreamReader
import zstandard

logger = logging.getLogger(__name__)
LARGEST_CHUNK_BYTES = 1 << 30  # unpacked; fifteen captures of the largest camera
# By the name of the compression: packed data and the most bytes to unpack, to unpacked data.
DECOMPRESSORS: dict[str, Callable[[bytes, int], bytes]] = {
    '': lambda data, _: data,
    'lz4': lambda data, most: lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=most),
    'zstd': lambda data, most: zstandard.ZstdDecompressor().stream_reader(data).read(most)}


class RawMessage(NamedTuple):
    """A message as it lies in the file.

    Attributes:
        topic: the recorded topic.
        type_name: such as ``sensor_msgs/msg/Image``.
        definition: the text of its type; empty when the storage has none.
        log_ns: time of recording [ns].
        data: the serialized message.
    """

    topic: str
    type_name: str
    definition: bytes
    log_ns: int
    data: bytes


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


def messages(file: Path) -> Iterator[RawMessage]:
    """Yield all whole messages in the order of the file, which is the order of recording.

    A damaged chunk is left out, and everything behind it if its end cannot be found. Both are
    logged.
    """
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    for record in _records(file):
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            channels[record.id] = record
        elif isinstance(record, Message):
            channel = channels.get(record.channel_id)
            schema = schemas.get(channel.schema_id) if channel else None
            if channel and schema:  # otherwise they were in a damaged chunk
                yield RawMessage(channel.topic, schema.name, schema.data, record.log_time,
                                 record.data)


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
