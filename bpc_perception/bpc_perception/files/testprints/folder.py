"""The folder of a test print: all of its files, or none, and over nothing."""

from __future__ import annotations

from contextlib import suppress
import math
import os
from pathlib import Path
import tempfile

from bpc_perception.core.testprints.plan import TestPrint
from bpc_perception.files.testprints.path_files import g_code, path_csv
from bpc_perception.files.testprints.stroke_table import stroke_table, SUFFIX


def write_test_print(folder: Path, test: TestPrint, plunger: float = math.nan) -> list[Path]:
    """Write NAME.csv, NAME.gcode and NAME_strokes.csv of a test print; return them.

    Args:
        folder: where to; made if missing.
        test: what is printed.
        plunger: inner diameter of the syringe [m]; see ``g_code``.

    Raises:
        ValueError: one of them is there already.
        OSError: the folder cannot be written to.
    """
    files = {f'{test.name}.csv': path_csv(test), f'{test.name}.gcode': g_code(test, plunger),
             f'{test.name}{SUFFIX}': stroke_table(test)}
    there = sorted(name for name in files if (folder / name).exists())
    if there:
        raise ValueError(f'{folder}: expected no {there[0]} there, found one'
                         '; name another folder with --out, or move it away')
    folder.mkdir(parents=True, exist_ok=True)
    placed: list[Path] = []
    with tempfile.TemporaryDirectory(prefix='.bpc-', dir=folder) as beside:
        for name, text in files.items():
            Path(beside, name).write_text(text, encoding='utf-8')
        try:
            for name in files:
                os.link(Path(beside, name), folder / name)  # fails where one is there meanwhile
                placed.append(folder / name)
        except BaseException:
            for path in placed:
                with suppress(OSError):
                    path.unlink()
            raise
    return placed
