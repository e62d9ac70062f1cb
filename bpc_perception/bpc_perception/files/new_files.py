"""Write files that are new: all of them or none, and over nothing."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import tempfile


def write_new(folder: Path, texts: Mapping[str, str]) -> None:
    """Write texts into new files of a folder, which is made if missing.

    Raises:
        ValueError: one of them is there already, or the folder is a file.
        OSError: the folder cannot be written to.
    """
    expect_new(folder, *texts)
    folder.mkdir(parents=True, exist_ok=True)
    placed: list[Path] = []
    with tempfile.TemporaryDirectory(prefix='.bpc-', dir=folder) as beside:
        for name, text in texts.items():
            Path(beside, name).write_text(text, encoding='utf-8')
        try:
            for name in texts:
                os.link(Path(beside, name), folder / name)  # fails where one is there by now
                placed.append(folder / name)
        except BaseException:
            for path in placed:
                with suppress(OSError):
                    path.unlink()
            raise


def expect_new(folder: Path, *names: str) -> None:
    """Raise ValueError where one of these files is there already, or no folder can be."""
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not existing.is_dir():
        raise ValueError(f'{folder}: expected a folder for files, found that {existing} is a file'
                         '; name another with --out')
    there = sorted(name for name in names if (folder / name).exists())
    if there:
        raise ValueError(f'{folder}: expected no {there[0]} there, found one'
                         '; name another folder with --out, or move it away')
