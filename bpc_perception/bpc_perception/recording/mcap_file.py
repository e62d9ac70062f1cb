"""MCAP files that may be torn, damaged or made to harm: what is whole in them, and no more memory.

A length in a damaged file may be anything. What the ``mcap`` package is asked to read is
therefore bounded by the size of the file, and a chunk that is to be unpacked by ``LARGEST_CHUNK``.
"""

from __future__ import annotations

from collections.abc import Iterator
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
LARGEST_CHUNK = 1 << 30  # unpacked, fifteen captures of the largest camera [bytes]


class RawMessage(NamedTuple):
    """A message as it lies in the file.

    Attributes:
        topic: where it was heard.
        type_name: such as ``sensor_msgs/msg/Image``.
        definition: the text of its type.
        log_ns: time of recording [ns].
        data: the serialized message.
    """

    topic: str
    type_name: str
    definition: bytes
    log_ns: int
    data: bytes


class BoundedFile:
    """A file that refuses to read more than it has, instead of making room for it first."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._size = os.fstat(stream.fileno()).st_size

    def read(self, length: int = -1) -> bytes:
        """So many bytes, all of them. Raises EOFError."""
        left = self._size - self._stream.tell()
        if length > left:
            raise EOFError(f'expected {length} bytes, found {left}')
        return self._stream.read(length)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go there."""
        return self._stream.seek(offset, whence)

    def tell(self) -> int:
        """Where it is."""
        return self._stream.tell()

    def seekable(self) -> bool:
        """Whether it can go anywhere."""
        return True


def bounded(stream: BinaryIO) -> Any:
    """The file, bounded, for the package: it asks for an IO[bytes] and uses no more than this."""
    return BoundedFile(stream)


def summary(file: Path) -> Summary | None:
    """What the end of a file says of its content; None where it is torn."""
    try:
        with file.open('rb') as stream:
            return make_reader(bounded(stream)).get_summary()
    except Exception:  # as in _records
        return None


def metadata(file: Path, name: str) -> dict[str, str]:
    """What the first metadata record of this name says; nothing where there is none."""
    return next((record.metadata for record in _records(file)
                 if isinstance(record, Metadata) and record.name == name), {})


def messages(file: Path) -> Iterator[RawMessage]:
    """All messages that are whole, in the order of the file, which is that of recording.

    A damaged chunk is left out, and all behind it if its end cannot be found. Either is logged.
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
            if channel and schema:  # or else they were in a damaged chunk
                yield RawMessage(channel.topic, schema.name, schema.data, record.log_time,
                                 record.data)


def _records(file: Path) -> Iterator[McapRecord]:
    """All records; those in a chunk in its place."""
    # On damaged bytes the package lets through what its parts raise: struct.error, MemoryError,
    # UnicodeDecodeError, KeyError, the decompressors' own and more.
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
    """The records of a chunk; none if it is damaged."""
    try:
        if chunk.uncompressed_size > LARGEST_CHUNK:
            raise ValueError(f'expected at most {LARGEST_CHUNK} bytes, '
                             f'found {chunk.uncompressed_size}')
        data, size = chunk.data, chunk.uncompressed_size
        # One byte more than there should be tells that there is more.
        if chunk.compression == 'lz4':
            data = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
        elif chunk.compression == 'zstd':
            data = zstandard.ZstdDecompressor().stream_reader(data).read(size + 1)
        elif chunk.compression:
            raise ValueError(f'expected lz4 or zstd, found {chunk.compression!r}')
        if len(data) != size:
            raise ValueError(f'expected {size} bytes, found others')
        return breakup_chunk(replace(chunk, compression='', data=data), validate_crc=True)
    except Exception as error:
        logger.warning('%s: left out a damaged chunk (%s)', file, type(error).__name__)
        return []
