"""The folder that results are written into: as a whole, and over nothing that is not ours."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, ExitStack, suppress
import json
import os
from pathlib import Path
import re
import shutil
import tempfile
from typing import Any

from bpc_perception.claims.folder import FolderClaim
from bpc_perception.report.tables.files import is_ours

SUMMARY = 'summary.json'
# What a result consists of. Other files in its folder belong to someone else, and stay.
# Of `bpc printability`: it is about a result, and goes with it.
PRINTABILITY = re.compile(r'printability\.csv|pores(_layers_[\d_]+)?\.(pdf|svg)')
# Of `bpc testprint judge`, likewise.
TEST_PRINT = re.compile(r'sweep\.csv|findings\.csv')
OURS = re.compile(r'profile\.(csv|xlsx|mat)|repair\.csv|summary\.json|report\.html|figures|'
                  rf'capture_\d{{4,}}|print_\d+|{PRINTABILITY.pattern}|{TEST_PRINT.pattern}')


def check_out(folder: Path) -> None:
    """Raise ValueError unless results can be written to this folder, which is made if missing.

    It is to be new, empty, or one with an earlier result, which is replaced. It is not to be that
    of a recording, or of a print that was measured live: these cannot be made again.
    """
    if recorded := holds_recording(folder):
        raise ValueError(f'{folder}: expected a folder for results of their own, found that of '
                         f'a recording or a live print, with {recorded}; name another with --out')
    if expect_room_for(folder, 'the outputs') != folder or _holds_result(folder):
        return
    foreign = next((path.name for path in sorted(folder.iterdir())
                    if not path.name.startswith('.')), None)
    if foreign is not None:
        raise ValueError(f'{folder}: expected a new folder, an empty one, or an earlier result '
                         f'of bpc, found {foreign}; name another with --out')


def check_recording(folder: Path, bag: Path) -> None:
    """Raise ValueError if a folder has the result of another recording than this one.

    Recordings in different folders may have equal names, and their results must not take the
    place of each other.
    """
    try:
        earlier = read_summary(folder)['bag']
        same = not earlier or Path(earlier).resolve() == bag.resolve()
    except (OSError, ValueError, LookupError, TypeError):
        return  # none that can be told from another
    if not same:
        raise ValueError(f'{folder}: expected no results there but those of {bag}, found those '
                         f'of {earlier}; name another folder with --out, or remove it')


def read_summary(folder: Path) -> dict[str, Any]:
    """Return the summary of the result in a folder. Raises OSError, ValueError."""
    summary: dict[str, Any] = json.loads((folder / SUMMARY).read_text('utf-8'))
    return summary


def expect_summary(folder: Path) -> dict[str, Any]:
    """Return the summary of the result in a folder.

    Raises:
        OSError: it cannot be read.
        ValueError: it is none; the message names what was expected and found.
    """
    file = folder / SUMMARY
    try:
        summary = read_summary(folder)
    except ValueError as error:
        raise ValueError(f'{file}: expected a summary as JSON, found: {error}'
                         '; measure it again') from error
    if not isinstance(summary, dict):
        raise ValueError(f'{file}: expected a summary as JSON, found a {type(summary).__name__}'
                         '; measure it again')
    return summary


def part_of(summary: dict[str, Any], name: str) -> dict[str, Any]:
    """Return what a summary has in braces under a name; nothing where it has no such thing."""
    found = summary.get(name)
    return found if isinstance(found, dict) else {}


def holds_recording(folder: Path) -> str:
    """Return the name of a recording in a folder, or of a folder with one; empty = none."""
    patterns = '*.mcap', '*.db3', '*/*.mcap', '*/*.db3'
    found = sorted(path for pattern in patterns for path in folder.glob(pattern))
    return str(found[0].relative_to(folder)) if found else ''


def expect_room_for(folder: Path, what: str) -> Path:
    """Return the folder, or the nearest one above it that exists; ValueError = it is a file."""
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not existing.is_dir():
        raise ValueError(f'{folder}: expected a folder for {what}, '
                         f'found that {existing} is a file; name another with --out')
    return existing


@contextmanager
def replacing(folder: Path, ours: re.Pattern[str] = OURS, last: str = SUMMARY) -> Iterator[Path]:
    """Give the block an empty folder whose content then replaces what a result has in ``folder``.

    Nothing is changed if the block raises an exception. One file is moved last: where it is
    new, all the rest is in place. What a process that was killed left unfinished is removed.

    Args:
        folder: made if missing.
        ours: names of what a result consists of; other files stay.
        last: name of the file that tells whether there is a result.

    Raises OSError if the folder cannot be written to, HeldError if another process does that now.
    """
    made = [path for path in (folder, *folder.absolute().parents) if not path.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    with ExitStack() as undo:
        for path in reversed(made):
            undo.callback(_remove_if_empty, path)
        undo.enter_context(FolderClaim(folder, 'write results there'))
        for leftover in folder.glob('.bpc-*'):
            shutil.rmtree(leftover, ignore_errors=True)
        new = undo.enter_context(tempfile.TemporaryDirectory(prefix='.bpc-', dir=folder))
        yield Path(new)
        (folder / last).unlink(missing_ok=True)  # from here on it is no result
        for path in list(folder.iterdir()):
            if ours.fullmatch(path.name) and not _is_of_others(path):
                shutil.rmtree(path) if path.is_dir() else path.unlink()
        for path in sorted(Path(new).iterdir(), key=lambda path: path.name == last):
            os.replace(path, folder / path.name)


def _is_of_others(path: Path) -> bool:
    """Return whether a table is named like one of ours, but was made or changed by others."""
    return path.suffix in ('.xlsx', '.mat') and not is_ours(path)


def _remove_if_empty(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()


def _holds_result(folder: Path) -> bool:
    try:
        return 'fingerprint' in read_summary(folder)
    except (OSError, ValueError, TypeError):
        return False
