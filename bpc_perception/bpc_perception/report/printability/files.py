"""The files that tell the printability of a print, and the folder they are written into."""

from __future__ import annotations

import csv
from pathlib import Path

from bpc_perception.core.printability.assess import Printability
from bpc_perception.report.printability.rows import COLUMNS, FILE, printability_csv
from bpc_perception.report.result_folder import expect_room_for, PRINTABILITY, replacing


def check_out(folder: Path, print_id: str) -> None:
    """Raise ValueError if files of this print would replace what is of others in a folder."""
    if expect_room_for(folder, 'the numbers') != folder:
        return
    there = sorted(path.name for path in folder.iterdir() if PRINTABILITY.fullmatch(path.name))
    if not there:
        return
    found = _print_of(folder / FILE)
    if found != print_id:
        what = f'that of {found!r}' if found is not None else there[0]
        raise ValueError(f'{folder}: expected no {FILE} there but that of {print_id!r}, '
                         f'found {what}; name another folder with --out')


def write(folder: Path, found: Printability, print_id: str, figures: bool) -> list[Path]:
    """Write the numbers, and figures if wanted, all or none; return the files.

    Raises OSError if the folder cannot be written to, HeldError if another process does that now.
    """
    files = {FILE: printability_csv(found, print_id).encode('utf-8', 'replace')}
    if figures:
        # Imported late: matplotlib is an extra, and is slow to load.
        from bpc_perception.report.printability.figure import draw_pores

        files |= draw_pores(found)
    with replacing(folder, PRINTABILITY, FILE) as new:
        for name, data in files.items():
            (new / name).write_bytes(data)
    return [folder / name for name in files]


def _print_of(file: Path) -> str | None:
    """Return the print that an earlier file is about; None = it is not ours, or not there."""
    try:
        with file.open(encoding='utf-8', newline='') as stream:
            reader = csv.DictReader(stream)
            if tuple(reader.fieldnames or ()) != COLUMNS:
                return None
            return str(next(reader)['print'])
    except (OSError, ValueError, StopIteration, csv.Error):
        return None
