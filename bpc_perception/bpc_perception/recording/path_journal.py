"""Keep the running print on disk, so that a path recorder that was killed can resume it.

The journal is an MCAP file of the updates of the path. Each update is handed to the operating
system before it is published, so a point that a node has received is the same after a restart. The
file has no chunks: nothing is held back, and no index grows in memory.
"""

from __future__ import annotations

from contextlib import suppress
import math
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
from bpc_perception.recording.bag import Bag, BagError
from bpc_perception.recording.storage import mcap_file

NO_HOME = '/nonexistent'  # as Debian has it for users without one
TOPIC = f'/{topics.PATH_UPDATE}'
SETTINGS = 'path_recorder'  # name of the metadata record
# Prefixes of the parameters on which the points of a path depend.
PATH_PARAMETERS = ('base_frame', 'nozzle_offset', 'pose.', 'path.')
# Then the file is begun anew with the whole path, so that it can be read quickly.
MOST_RECORDS = 3000
ALIVE_PERIOD_NS = 500_000_000  # how often an update without news says that the print goes on


class OtherSettingsError(ValueError):
    """A print was left off with settings that give other points from the same poses."""


def default_folder(namespace: str = '') -> Path:
    """Return the folder for a user's running prints [XDG Base Directory Specification].

    Each namespace of each ROS domain has its own folder. A user without a home has one that cannot
    be written to.
    """
    try:
        home = os.environ.get('XDG_STATE_HOME') or Path.home() / '.local' / 'state'
    except RuntimeError:
        home = NO_HOME
    return Path(home, 'bpc', f'domain_{os.environ.get("ROS_DOMAIN_ID") or 0}',
                *namespace.strip('/').split('/'))


class PathJournal:
    """The newest print in a folder, with its path as far as it is known."""

    def __init__(self, folder: Path, config: RecorderConfig) -> None:
        """Make the folder. Raises OSError when that fails."""
        folder.mkdir(parents=True, exist_ok=True)
        self._file = folder / 'running_print.mcap'
        self._frame_id = config.base_frame
        self._settings = {name: str(value) for name, _, value in flatten(config)
                          if name.startswith(PATH_PARAMETERS)}
        self._stream: IO[bytes] | None = None
        self._print_id = ''
        self._points = self._records = self._written_ns = 0
        self._ended = False
        self._given_up = ''

    def resume(self, now_ns: int, within: float = math.inf,
               ended_too: bool = False) -> GrowingPath | None:
        """Return the print that was running up to ``within`` seconds before ``now_ns``.

        None: there is no such print, or it has ended, unless those are asked for as well, or it
        was written in the future, since the clock has jumped.

        Raises:
            OSError: the file cannot be opened.
            OtherSettingsError: the print has other settings, so new points do not fit to its own.
        """
        path = self._read()
        if path is None or (path.finished and not ended_too):
            return None
        if not 0 <= now_ns - self._written_ns <= within * 1e9:
            return None
        before = mcap_file.metadata(self._file, SETTINGS)
        others = [f'{name} {before.get(name, "unknown")} instead of {value}'
                  for name, value in self._settings.items() if before.get(name) != value]
        if others:
            raise OtherSettingsError(f'print: expected {path.print_id} to be of the same '
                                     f'settings, found {", ".join(others)}'
                                     '; start with those to go on with it')
        return path

    def _read(self) -> GrowingPath | None:
        """Return the path in the file; None when it has none, or more damage than a kill does."""
        if self._file.exists() and not self._file.is_file():
            raise OSError(f'{self._file}: expected a file, found something else; remove it')
        path: GrowingPath | None = None
        try:
            for _, log_ns, update in Bag(self._file).messages({TOPIC}):
                part = path_from_message(update.path)
                if path is None:
                    path = GrowingPath(part.print_id, part.start_ns, update.first)
                path.extend(update.first, part)
                self._written_ns = log_ns
        except (BagError, ConversionError):
            return None
        return path

    def take(self, path: GrowingPath, now_ns: int) -> None:
        """Write what is new of a path. Call it before the path is published.

        Raises OSError when that fails, once for each print; nothing is kept of that print.
        """
        if path.print_id == self._given_up or not self._has_news(path, now_ns):
            return
        try:
            if (path.print_id != self._print_id or self._records >= MOST_RECORDS
                    or not self._in_place()):
                self._begin(path)
            self._write(path, now_ns)
        except OSError:
            self._given_up = path.print_id
            with suppress(OSError):  # the first error tells more
                self.remove()
            raise

    def _in_place(self) -> bool:
        """Return whether the file is still found, and was not removed with its folder."""
        assert self._stream is not None
        try:
            return os.path.samestat(self._file.stat(), os.fstat(self._stream.fileno()))
        except FileNotFoundError:
            return False

    def _has_news(self, path: GrowingPath, now_ns: int) -> bool:
        if path.print_id != self._print_id:
            return True
        if self._ended:
            return not path.finished  # it goes on
        due = now_ns - self._written_ns >= ALIVE_PERIOD_NS
        return due or path.finished or len(path) > self._points

    def remove(self) -> None:
        """Forget the print, on disk as well. Raises OSError when it cannot be removed."""
        self.close()
        self._file.unlink(missing_ok=True)

    def close(self) -> None:
        """Close the file; the next path begins it anew."""
        self._print_id = ''
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    def _begin(self, path: GrowingPath) -> None:
        """Begin a new file, which replaces the old one once it has its first record."""
        self.close()
        self._file.parent.mkdir(parents=True, exist_ok=True)  # somebody may have removed it
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
