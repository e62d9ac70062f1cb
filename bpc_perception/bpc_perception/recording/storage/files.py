"""Find the storage files of a recording."""

from __future__ import annotations

from collections.abc import Iterable
import logging
from pathlib import Path
from typing import Any

from bpc_perception.files.yaml_file import FileError, read_yaml
from bpc_perception.recording.print_folder import recordings_in
from bpc_perception.recording.storage.packing import PACKED
from bpc_perception.recording.storage.raw_message import BagError

logger = logging.getLogger(__name__)
MCAP, SQLITE = '.mcap', '.db3'
METADATA = 'metadata.yaml'
METADATA_BYTES = 10_000_000  # at most; a thousand topics have one
SUFFIXES = tuple(kind + packed for kind in (MCAP, SQLITE) for packed in ('', *PACKED))


def is_storage_file(path: str | Path) -> bool:
    """Return whether this is the name of a storage file, which may be packed."""
    return str(path).endswith(SUFFIXES)


def storage_files(path: Path) -> list[Path]:
    """Return the storage files of a recording, in the order in which they were recorded.

    The folder of a print stands for all of its recordings. Raises BagError when there are none.
    """
    if path.is_file() and is_storage_file(path):
        return [path]
    if not path.exists():
        raise BagError(f'{path}: expected a bag, found nothing there'
                       '; name the folder or file of a recording')
    if recordings := recordings_in(path):  # more than one after a crash
        return [file for recording in recordings for file in storage_files(recording)]
    files = path.is_dir() and (listed_files(path) or files_among(path.iterdir()))
    if not files:
        raise BagError(f'{path}: expected a rosbag2 folder or an .mcap or .db3 file, '
                       'found neither; name one of these')
    return files


def description(folder: Path) -> dict[str, Any]:
    """Return what metadata.yaml says of a recording; empty when it is missing or unfit."""
    try:
        content = read_yaml(folder / METADATA, METADATA_BYTES, aliases=True)
        found = content['rosbag2_bagfile_information']
    except (FileError, LookupError, TypeError):
        return {}
    return found if isinstance(found, dict) else {}


def listed_files(folder: Path) -> list[Path]:
    """Return the files that metadata.yaml lists, in its order, as far as they are there."""
    listed = description(folder).get('relative_file_paths')
    if not isinstance(listed, list):
        return []
    names = [Path(str(name)).name for name in listed]
    there = {plain_name(file): file for file in files_among(folder.iterdir())}
    # A file may have been packed or unpacked since, by somebody else.
    names = [plain_name(Path(name)) for name in names if is_storage_file(name)]
    for name in names:
        if there and name not in there:
            logger.warning('%s: left out %s, which metadata.yaml lists, but which is not there',
                           folder, name)
    return [there[name] for name in names if name in there]


def kind_of(file: Path) -> str:
    """Return MCAP or SQLITE, by the name of a storage file."""
    return Path(plain_name(file)).suffix


def files_among(entries: Iterable[Path]) -> list[Path]:
    """Return the storage files in a folder, 2 before 10; of one packed and unpacked, that one."""
    found = sorted((file for file in entries if is_storage_file(file) and not file.is_dir()),
                   key=lambda file: (len(plain_name(file)), plain_name(file)))
    names = {file.name for file in found}
    return [file for file in found if file.suffix not in PACKED or file.stem not in names]


def plain_name(file: Path) -> str:
    """Return the name of a storage file once it is unpacked."""
    return file.stem if file.suffix in PACKED else file.name
