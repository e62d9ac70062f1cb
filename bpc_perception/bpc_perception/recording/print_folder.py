"""The folder of a print that was measured live."""

from __future__ import annotations

from pathlib import Path
import re

from bpc_perception.core.path.print_id import start_of

PRINTS = Path('prints')  # where the folders are unless told otherwise
RECORDING = 'recording'  # in the folder of a print


def print_folder(prints: Path, print_id: str) -> Path:
    """Return the folder of a print: the local time of its start, to the millisecond.

    All who write into it find it from the print alone. Of an identifier by somebody else, which
    has no time, it has the letters that a file name may have.
    """
    start = start_of(print_id)
    if start is None:
        name = ''.join(letter if letter.isalnum() or letter in '-_.' else '_'
                       for letter in print_id.lstrip('.'))
        return prints / (name or '_')
    local = start.astimezone()
    return prints / f'{local:%Y-%m-%d_%H-%M-%S}.{local.microsecond // 1000:03d}'


def recordings_in(folder: Path) -> list[Path]:
    """Return the folders of recordings in the folder of a print, in their order."""
    return sorted((path for path in folder.glob(f'{RECORDING}*')
                   if path.is_dir() and re.fullmatch(rf'{RECORDING}(_\d+)?', path.name)),
                  key=lambda path: (len(path.name), path.name))


def free_recording(folder: Path) -> Path:
    """Return where a recording in the folder of a print can begin: after a crash there is one."""
    number, place = 1, folder / RECORDING
    while place.exists():
        number += 1
        place = folder / f'{RECORDING}_{number}'
    return place
