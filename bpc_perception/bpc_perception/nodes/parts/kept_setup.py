"""Keep in the state folder what prints are set up with."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from bpc_perception.core.advice.setup import Setup
from bpc_perception.files.setup_file import load_setup, save_setup

SETUP = 'setup.json'  # in the state folder


class KeptSetup:
    """What the print was set up with, and on disk if there is a state folder.

    Attributes:
        setup: as it was kept last.
    """

    def __init__(self, folder: str, now_ns: Callable[[], int],
                 warn: Callable[[str], object]) -> None:
        """Read what is kept in a folder ('' = none); ``warn`` hears what cannot be kept."""
        self._file = Path(folder) / SETUP if folder else None
        self._now_ns, self._warn = now_ns, warn
        self.setup = load_setup(self._file, now_ns()) if self._file else Setup()

    def keep(self, setup: Setup) -> None:
        """Keep a setup, if it is another."""
        if setup == self.setup or self._file is None:
            return
        self.setup = setup
        try:
            save_setup(self._file, setup, self._now_ns())
        except OSError as error:
            self._warn(f'state_folder: expected to write {self._file}, found: {error}; '
                       'make room there, or let it be written to')
