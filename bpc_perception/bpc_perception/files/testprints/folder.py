"""The folder of a test print: all of its files, or none, and over nothing."""

from __future__ import annotations

import math
from pathlib import Path

from bpc_perception.core.testprints.plan import TestPrint
from bpc_perception.files.new_files import write_new
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
    write_new(folder, files)
    return [folder / name for name in files]
