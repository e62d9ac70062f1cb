"""Put a recording in its place whole or not at all, and only where it belongs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import os
from pathlib import Path
import tempfile
from typing import Any

from bpc_perception.recording.bag import BagError
from bpc_perception.recording.bag_writer import BagWriter


@contextmanager
def atomic_bag(target: str | Path,
               about: Mapping[str, Any] | None = None) -> Iterator[BagWriter]:
    """Yield a writer whose bag appears at ``target`` only once it is complete.

    See BagWriter for ``about``.

    Raises BagError when something is there already, OSError when it cannot be written.
    """
    target = Path(target)
    if target.exists():
        raise BagError(f'{target}: expected a new bag, found that it exists'
                       '; name another, or move it away')
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix='.bpc-', dir=target.parent) as beside:
        with BagWriter(Path(beside) / target.name, about=about) as bag:
            yield bag
        os.rename(Path(beside) / target.name, target)


def inside(folder: str | Path, name: str) -> Path:
    """Return the path of a name in a folder. Raises ValueError when the name leads elsewhere."""
    if name in ('', '.', '..') or '/' in name or '\0' in name:
        raise ValueError(f'{folder}: expected the name of a file in it, found {name!r}'
                         '; choose one without a folder')
    return Path(folder) / name
