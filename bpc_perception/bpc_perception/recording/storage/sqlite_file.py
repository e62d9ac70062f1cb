"""Read sqlite3 files of rosbag2, the default of Humble, whole or torn, without metadata.yaml."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Set
from contextlib import closing
import json
import logging
import sqlite3
from typing import Any

from mcap.records import Attachment, Metadata

from bpc_perception.recording.storage.mcap_file import SET_BACK_NS
from bpc_perception.recording.storage.packing import UnpackedFile
from bpc_perception.recording.storage.raw_message import BagError, Channel, RawMessage

logger = logging.getLogger(__name__)
CHANNELS = 'SELECT id, name, type, serialization_format, offered_qos_profiles FROM topics'
DEFINITIONS = 'SELECT topic_type, encoding, encoded_message_definition FROM message_definitions'
COUNTS = 'SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id'
SET_BACK = (
    'SELECT 1 FROM (SELECT timestamp, LAG(timestamp) OVER (PARTITION BY topic_id ORDER BY id) '
    'AS before FROM messages) WHERE timestamp < before - ? LIMIT 1')
IN_ORDER = ('SELECT topic_id, timestamp, data FROM messages '
            'WHERE topic_id IN (SELECT value FROM json_each(?)) ORDER BY id')
IN_TIME = IN_ORDER.replace('BY id', 'BY timestamp, id')


class SqliteFile:
    """A sqlite3 file of rosbag2."""

    def __init__(self, file: UnpackedFile) -> None:
        self._unpacked = file
        self._file = file.path

    def topics(self) -> dict[tuple[str, str], int]:
        """See Storage."""
        channels = self._channels()
        try:
            counts = dict(self._rows(COUNTS))
        except sqlite3.DatabaseError:  # torn: see what can be read
            return dict(Counter((raw.topic, raw.type_name) for raw in self.messages()))
        found: Counter[tuple[str, str]] = Counter()
        for number, channel in channels.items():
            found[channel.topic, channel.type_name] += counts.get(number, 0)
        return dict(found)

    def messages(self, topics: Set[str] | None = None) -> Iterator[RawMessage]:
        """See Storage; where the recorder's clock was set back, the order of the file counts."""
        channels = {number: channel for number, channel in self._channels().items()
                    if topics is None or channel.topic in topics}
        query = IN_ORDER if self._was_set_back() else IN_TIME
        try:
            for number, log_ns, data in self._rows(query, json.dumps(list(channels))):
                yield RawMessage(channels[number], log_ns, data, log_ns)
        except sqlite3.DatabaseError as error:
            logger.warning('%s: torn, read up to the damage (%s)', self._file, error)

    def beside_messages(self) -> Iterator[Attachment | Metadata]:
        """See Storage."""
        return iter(())

    def count(self, topic: str) -> int:
        """See Storage."""
        return sum(count for (name, _), count in self.topics().items() if name == topic)

    def span(self) -> tuple[int, int]:
        """See Storage."""
        times = [raw.log_ns for raw in self.messages()]
        if not times:
            raise BagError(f'{self._file}: expected messages, found none; is it the right '
                           'file?')
        return min(times), max(times)

    def _was_set_back(self) -> bool:
        """Return whether the recorder's clock was, or the file is torn and its index as well."""
        try:
            return any(self._rows(SET_BACK, SET_BACK_NS))
        except sqlite3.DatabaseError:
            return True

    def _channels(self) -> dict[int, Channel]:
        """Return the topics by the number that messages name them by."""
        try:
            definitions = {kind: (text.encode(), encoding)
                           for kind, encoding, text in self._rows(DEFINITIONS)}
        except sqlite3.DatabaseError:  # older than Iron
            definitions = {}
        try:
            return {number: Channel(topic, kind, *definitions.get(kind, (b'', 'ros2msg')),
                                    encoding, (('offered_qos_profiles', str(qos)),))
                    for number, topic, kind, encoding, qos in self._rows(CHANNELS)}
        except sqlite3.DatabaseError as error:
            raise BagError(f'{self._file}: expected a sqlite3 file of rosbag2, found: '
                           f'{error}; is it the right file?') from error

    def _rows(self, query: str, *values: int | str) -> Iterator[tuple[Any, ...]]:
        with closing(self._connected()) as database:
            yield from database.execute(query, values)

    def _connected(self) -> sqlite3.Connection:
        place = self._file.absolute().as_uri()  # which quotes what means something there
        try:
            database = sqlite3.connect(f'{place}?mode=ro', uri=True)
            database.execute('SELECT name FROM sqlite_master').fetchone()
        except sqlite3.OperationalError:
            # A killed recorder left a journal, and nothing can be written beside it.
            database = sqlite3.connect(f'{place}?immutable=1', uri=True)
        return database
