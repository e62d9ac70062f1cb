"""Keep the running print on disk, as far as the disk allows."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bpc_perception.claims.folder import FolderClaim
from bpc_perception.core.config import RecorderConfig
from bpc_perception.core.path.growing_path import GrowingPath
from bpc_perception.recording.path_journal import OtherSettingsError, PathJournal
from bpc_perception.runtime.diagnostics import Diagnostics


class PrintJournal:
    """The journal of a path recorder, for which no print and no service fails.

    What the disk refuses is refused on ``diagnostics``, and the node goes on without it. Without
    ``state_folder`` there is no journal, and nothing is kept.

    Raises HeldError if another process keeps its print in that folder.
    """

    def __init__(self, config: RecorderConfig, diagnostics: Diagnostics) -> None:
        self._diagnostics = diagnostics
        self._resume = config.resume
        self._resume_within = config.resume_within
        self._journal: PathJournal | None = None
        self._claim: FolderClaim | None = None
        if config.state_folder:
            folder = Path(config.state_folder)
            with self._refusing('state_folder: expected one to write to'):
                self._journal = PathJournal(folder, config)
                self._claim = FolderClaim(folder, 'keep a running print there')

    def resume(self, now_ns: int) -> GrowingPath | None:
        """Return the print to go on with, as a rule one that ran when the node was killed.

        None: there is none.
        """
        if self._journal is None or self._resume == 'none':
            return None
        try:
            with self._refusing('journal: expected a print to go on with'):
                if self._resume == 'newest':
                    return self._journal.resume(now_ns, ended_too=True)
                return self._journal.resume(now_ns, self._resume_within)
        except OtherSettingsError as error:
            self._diagnostics.warn(f'{error}; it is not resumed')
        return None

    def keep(self, path: GrowingPath, now_ns: int) -> None:
        """Write what is new of a path. Call it before the path is published."""
        if self._journal is not None:
            with self._refusing('journal: expected to keep the print on disk'):
                self._journal.take(path, now_ns)

    def forget(self) -> None:
        """Remove the print from disk."""
        if self._journal is not None:
            with self._refusing('journal: expected to remove the print from disk'):
                self._journal.remove()

    def close(self) -> None:
        """Close the file; what is in it stays."""
        if self._journal is not None:
            self._journal.close()
        if self._claim is not None:
            self._claim.release()

    @contextmanager
    def _refusing(self, expected: str) -> Iterator[None]:
        """Refuse an OSError of the block with what was expected, instead of raising it."""
        try:
            yield
        except OSError as error:
            self._diagnostics.refuse(f'{expected}, found: {error}')
