"""Claim a folder: what is in it is written by one process alone.

The claim is a lock on the folder itself (flock), so it leaves no file behind.
"""

from __future__ import annotations

import fcntl
import os
from pathlib import Path
from types import TracebackType

from bpc_perception.claims.holder import described, HeldError


class FolderClaim:
    """The claim of a folder, until ``release``; a context manager.

    Where the file system has no locks, everybody has the claim.

    Raises HeldError if another process has it, OSError if the folder cannot be opened.
    """

    def __init__(self, folder: Path, purpose: str) -> None:
        self._handle: int | None = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            holder = described(_locker(self._handle))
            self.release()
            raise HeldError(f'{folder}: expected to be the only one to {purpose}, found {holder}; '
                            'stop it, or name another folder') from None
        except OSError:
            self.release()

    def release(self) -> None:
        """Give the folder back."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None

    def __enter__(self) -> FolderClaim:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.release()


def _locker(handle: int) -> int:
    """Return the id of the process that locked an open folder; 0 = not known."""
    state = os.fstat(handle)
    place = f'{os.major(state.st_dev):02x}:{os.minor(state.st_dev):02x}:{state.st_ino}'
    try:
        lines = Path('/proc/locks').read_text().splitlines()
    except OSError:
        return 0
    # For example: 1: FLOCK ADVISORY WRITE 1234 fe:01:5678 0 EOF
    found = [int(words[4]) for words in map(str.split, lines)
             if words[1] == 'FLOCK' and words[5] == place]
    return max(found, default=0)
