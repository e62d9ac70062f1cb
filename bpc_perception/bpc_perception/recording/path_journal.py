"""The running print on disk, so that a path recorder that was killed goes on with it.

An MCAP file of the updates of the path, each handed to the operating system before it is
published: whoever heard of a point can be sure that it is the same after a restart. It has no
chunks, so that nothing is held back and nothing piles up for an index.
"""

from __future__ import annotations

from contextlib import suppress
import os
from pathlib import Path
from typing import IO

from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import Writer
from rclpy.serialization import serialize_message

from bpc_interfaces.msg import DepositionPathUpdate
from bpc_perception.core.config import RecorderConfig
from bpc_perception.core.parameter import flatten
from bpc_perception.core.path.growing_path import GrowingPath
from bpc_perception.messages import topics
from bpc_perception.messages.path import path_from_message, path_to_message
from bpc_perception.messages.stamps import ConversionError
from bpc_perception.messages.types import message_definition
from bpc_perception.recording import mcap_file
from bpc_perception.recording.bag import Bag, BagError

TOPIC = f'/{topics.PATH_UPDATE}'
SETTINGS = 'path_recorder'  # name of the metadata
# What the points of a path depend on.
DECISIVE = ('base_frame', 'nozzle_offset', 'pose.', 'path.')


class OtherSettingsError(ValueError):
    """A print was left off with settings that make other points of the same poses."""


def default_folder(namespace: str = '') -> Path:
    """Where a user keeps running prints [XDG Base Directory Specification].

    One folder a ROS domain, and a namespace in it.
    """
    home = os.environ.get('XDG_STATE_HOME') or Path.home() / '.local' / 'state'
    return Path(home, 'bpc', f'domain_{os.environ.get("ROS_DOMAIN_ID") or 0}',
                *namespace.strip('/').split('/'))


class PathJournal:
    """The newest print in a folder, with the path as far as it is known."""

    RECORDS = 3000  # after which the file is begun anew with the whole path: so it is read quickly
    PERIOD_NS = 500_000_000  # in which it is said that a print without news goes on

    def __init__(self, folder: Path, config: RecorderConfig) -> None:
        """Raises OSError where the folder cannot be made."""
        folder.mkdir(parents=True, exist_ok=True)
        self._file = folder / 'running_print.mcap'
        self._frame_id = config.base_frame
        self._settings = {name: str(value) for name, _, value in flatten(config)
                          if name.startswith(DECISIVE)}
        self._stream: IO[bytes] | None = None
        self._print_id = ''
        self._points = self._records = self._written_ns = 0
        self._ended = False
        self._given_up = ''

    def resume(self, now_ns: int, within: float) -> GrowingPath | None:
        """The print that was running up to ``within`` seconds ago; None = there is none.

        An ended one is none, nor one of the future: then the clock has jumped.

        Raises:
            OSError: the file cannot be opened.
            OtherSettingsError: it was left off with others, so its points do not fit to new ones.
        """
        path: GrowingPath | None = None
        try:
            for _, log_ns, update in Bag(self._file).messages({TOPIC}):
                part = path_from_message(update.path)
                if path is None:
                    path = GrowingPath(part.print_id, part.start_ns, update.first)
                path.extend(update.first, part)
                self._written_ns = log_ns
        except (BagError, ConversionError):  # none, or damaged beyond what a kill does
            return None
        if path is None or path.finished or not 0 <= now_ns - self._written_ns <= within * 1e9:
            return None
        before = mcap_file.metadata(self._file, SETTINGS)
        others = [f'{name} {before.get(name, "unknown")} instead of {value}'
                  for name, value in self._settings.items() if before.get(name) != value]
        if others:
            raise OtherSettingsError(f'print: expected {path.print_id} to be of the same '
                                     f'settings, found {", ".join(others)}')
        return path

    def take(self, path: GrowingPath, now_ns: int) -> None:
        """Write what is new of a path, to be called before it is published.

        Raises OSError where that fails, once a print: then nothing is kept of it.
        """
        if path.print_id == self._given_up:
            return
        news = path.finished or len(path) > self._points
        recent = now_ns - self._written_ns < self.PERIOD_NS
        if path.print_id == self._print_id and (self._ended or (recent and not news)):
            return
        try:
            if path.print_id != self._print_id or self._records >= self.RECORDS:
                self._begin(path)
            self._write(path, now_ns)
        except OSError:
            self._given_up = path.print_id
            with suppress(OSError):  # the first tells more
                self.remove()
            raise

    def remove(self) -> None:
        """Forget the print, on disk as well. Raises OSError where it stays there."""
        self.close()
        self._file.unlink(missing_ok=True)

    def close(self) -> None:
        """Let go of the file; what comes next begins it anew."""
        self._print_id = ''
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    def _begin(self, path: GrowingPath) -> None:
        """A new file, which takes the place of the old one with its first record."""
        self.close()
        self._stream = self._file.with_suffix('.tmp').open('wb', buffering=0)
        self._writer = Writer(self._stream, use_chunking=False)
        self._writer.start(Profile.ROS2, library='bpc')
        self._writer.add_metadata(SETTINGS, self._settings)
        kind = topics.type_name(DepositionPathUpdate)
        schema = self._writer.register_schema(
            kind, SchemaEncoding.ROS2, message_definition(kind).encode())
        self._channel = self._writer.register_channel(TOPIC, MessageEncoding.CDR, schema)
        self._print_id, self._records, self._ended = path.print_id, 0, False
        self._points = path.oldest

    def _write(self, path: GrowingPath, now_ns: int) -> None:
        update = DepositionPathUpdate(
            first=self._points, path=path_to_message(path.path(self._points), self._frame_id))
        self._writer.add_message(self._channel, now_ns, serialize_message(update), now_ns,
                                 self._records)
        self._writer.flush()
        if self._records == 0:
            self._file.with_suffix('.tmp').replace(self._file)
        self._records += 1
        self._points, self._written_ns, self._ended = len(path), now_ns, path.finished
