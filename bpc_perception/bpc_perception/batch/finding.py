"""Find recordings below a folder, each once, whatever links lead to it."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
import logging
from pathlib import Path
import re

from bpc_perception.recording.print_folder import recordings_in
from bpc_perception.recording.storage.files import files_among, listed_files, plain_name

logger = logging.getLogger(__name__)


def find_bags(folder: Path) -> list[Path]:
    """Return all recordings in a folder and below, in order.

    A folder is a recording if its metadata.yaml lists files. Or else, as killed recorders leave
    it, if all its files are numbered from 0 behind one name, which is that of the folder unless
    there is a metadata.yaml. The folder of a print stands for all of its recordings. Each other
    .mcap or .db3 file is a recording by itself.

    Links are followed. A recording to which several ways lead is the one without links.
    """
    found = [each for place in _folders(folder) for each in _recordings(place)]
    bags: list[Path] = []
    seen: set[Path] = set()  # files of recordings, by their real paths
    for bag, files in sorted(found, key=lambda each: _is_linked(folder, *each)):
        real = {file.resolve() for file in files}
        if not real <= seen:
            bags.append(bag)
        seen |= real
    return sorted(bags)


def _folders(top: Path) -> Iterator[Path]:
    """Yield a folder and all below, each once: first those to which no link leads."""
    seen: set[Path] = set()
    waiting, links = deque([top]), deque[Path]()
    while waiting or links:
        folder = waiting.popleft() if waiting else links.popleft()
        if folder.resolve() in seen:
            continue
        seen.add(folder.resolve())
        yield folder
        if not recordings_in(folder):
            for entry in _entries(folder):
                if entry.is_dir():
                    (links if entry.is_symlink() else waiting).append(entry)


def _recordings(folder: Path) -> Iterator[tuple[Path, list[Path]]]:
    """Yield the recordings right in a folder, which may be one itself, with their files."""
    if recordings := recordings_in(folder):
        yield folder, [file for recording in recordings for file in _files(recording)]
        return
    files = _files(folder)
    parts = _parts(folder, files)
    if parts:
        yield folder, parts
    for file in files:
        if file not in parts:
            yield file, [file]


def _parts(folder: Path, files: list[Path]) -> list[Path]:
    """Return the files of the recording that a folder is; none if it is not one."""
    if listed := listed_files(folder):
        return listed
    names = [Path(plain_name(file)).stem for file in files]
    numbered = [match for name in names if (match := re.fullmatch(r'(.+)_(\d+)', name))]
    stems = {match[1] for match in numbered}
    described = stems == {folder.absolute().name} or (folder / 'metadata.yaml').exists()
    # A reader takes all files of a folder without a list: none may be of another recording.
    whole = len(numbered) == len(files) and len(stems) == 1 and (
        sorted(int(match[2]) for match in numbered) == [*range(len(files))])
    return files if described and whole else []


def _files(folder: Path) -> list[Path]:
    return files_among(_entries(folder))


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError as error:
        logger.warning('%s: expected a folder to look into, found: %s; let it be read, or leave '
                       'it out', folder, error.strerror)
        return []


def _is_linked(top: Path, bag: Path, files: list[Path]) -> bool:
    """Return whether one gets from a folder to a recording, or to a file of it, by a link."""
    return any(path.is_symlink() for path in (*files, bag, *bag.parents)
               if path != top and top in path.parents)
