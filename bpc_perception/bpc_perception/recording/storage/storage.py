"""One way to read a storage file, whatever wrote it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Set
from pathlib import Path
from typing import Protocol

from mcap.records import Attachment, Metadata

from bpc_perception.recording.storage import mcap_file
from bpc_perception.recording.storage.files import SQLITE
from bpc_perception.recording.storage.packing import UnpackedFile
from bpc_perception.recording.storage.raw_message import BagError, RawMessage
from bpc_perception.recording.storage.sqlite_file import SqliteFile


class Storage(Protocol):
    """A storage file of a recording. All methods raise BagError."""

    def topics(self) -> dict[tuple[str, str], int]:
        """Return each topic and type with the number of its messages; 1 if it is not stated."""

    def messages(self, topics: Set[str] | None = None) -> Iterator[RawMessage]:
        """Yield the messages of these topics, or all, in the order of recording."""

    def beside_messages(self) -> Iterator[Attachment | Metadata]:
        """Yield what lies in the file beside its messages."""

    def count(self, topic: str) -> int | None:
        """Return the number of messages of a topic; None when the file does not state it."""

    def span(self) -> tuple[int, int]:
        """Return the times of the first and the last message [ns]."""


def open_storage(file: Path) -> Storage:
    """Return a storage file to read, which may be packed. Raises BagError."""
    unpacked = UnpackedFile(file)
    return (SqliteFile if unpacked.path.suffix == SQLITE else McapFile)(unpacked)


class McapFile:
    """An MCAP file. Its summary is missing when the file is torn; then messages are counted."""

    def __init__(self, file: UnpackedFile) -> None:
        self._file = file

    def topics(self) -> dict[tuple[str, str], int]:
        """See Storage."""
        summary = mcap_file.summary(self._file.path)
        if summary is not None and summary.statistics is not None and all(
                channel.schema_id in summary.schemas for channel in summary.channels.values()):
            counts = summary.statistics.channel_message_counts
            found: Counter[tuple[str, str]] = Counter()
            for number, channel in summary.channels.items():
                kind = mcap_file.full_name(summary.schemas[channel.schema_id].name)
                found[channel.topic, kind] += counts.get(number, 0)
            return dict(found)
        return dict(Counter((message.topic, message.type_name)
                            for message in mcap_file.messages(self._file.path)))

    def messages(self, topics: Set[str] | None = None) -> Iterator[RawMessage]:
        """See Storage."""
        return mcap_file.messages_in_time(self._file.path, topics)

    def beside_messages(self) -> Iterator[Attachment | Metadata]:
        """See Storage."""
        return mcap_file.beside_messages(self._file.path)

    def count(self, topic: str) -> int | None:
        """See Storage."""
        summary = mcap_file.summary(self._file.path)
        if summary is None or summary.statistics is None:
            return None
        return sum(summary.statistics.channel_message_counts.get(number, 0)
                   for number, channel in summary.channels.items() if channel.topic == topic)

    def span(self) -> tuple[int, int]:
        """See Storage."""
        summary = mcap_file.summary(self._file.path)
        if summary is not None and summary.statistics is not None:
            return summary.statistics.message_start_time, summary.statistics.message_end_time
        times = [message.log_ns for message in self.messages()]
        if not times:
            raise BagError(f'{self._file.path}: expected messages, found none; is it the '
                           'right file?')
        return min(times), max(times)
