"""The thickness wanted: the same everywhere, or along the path."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import LARGEST_TARGET_M, LEAST_TARGET_M

COLUMNS = ['arc_length_mm', 'thickness_mm']
MILLIMETRE_M = 1e-3
LARGEST_BYTES = 10_000_000  # of a table


@dataclass(frozen=True)
class WidthTargets:
    """Thickness over arc length, linear between the rows of a table and constant beyond its ends.

    Two rows of one arc length make a step.

    Attributes:
        arc_length: (K,) [m], never decreasing.
        thickness: (K,) [m].
    """

    arc_length: Array
    thickness: Array

    @classmethod
    def constant(cls, thickness: float) -> WidthTargets:
        """Return targets with the same thickness [m] everywhere."""
        return cls(np.zeros(1), np.array([thickness]))

    @classmethod
    def read(cls, file: str | Path) -> WidthTargets:
        """Read a table from a CSV file with the columns arc_length_mm and thickness_mm.

        Raises:
            OSError: the file cannot be read.
            ValueError: it is no such table; the message names what was expected and found.
        """
        table = _numbers(file, _rows(file))
        arc_length, thickness = table.T * MILLIMETRE_M
        if not (np.isfinite(table).all() and (np.diff(arc_length) >= 0).all()):
            raise ValueError(f'{file}: expected arc lengths in order, found others')
        outside = table[(thickness < LEAST_TARGET_M) | (thickness > LARGEST_TARGET_M), 1]
        if len(outside):
            least, most = (limit / MILLIMETRE_M for limit in (LEAST_TARGET_M, LARGEST_TARGET_M))
            raise ValueError(f'{file}: expected thicknesses from {least:g} to {most:g} mm, '
                             f'found {outside[0]:g}; are they in millimetres?')
        return cls(arc_length, thickness)

    def at(self, arc_length: Array | float) -> Array:
        """Return the thickness (...) at these arc lengths (...) [m]."""
        return np.asarray(np.interp(arc_length, self.arc_length, self.thickness))


def _rows(file: str | Path) -> list[list[str]]:
    """Read the rows of a table below its columns."""
    with Path(file).open('rb') as stream:
        content = stream.read(LARGEST_BYTES + 1)
    if len(content) > LARGEST_BYTES:
        raise ValueError(f'{file}: expected at most {LARGEST_BYTES} bytes, found more')
    try:
        rows = [row for row in csv.reader(content.decode('utf-8').splitlines()) if row]
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f'{file}: expected a table, found: {error}') from error
    if not rows or [cell.strip() for cell in rows[0]] != COLUMNS:
        raise ValueError(f'{file}: expected the columns {",".join(COLUMNS)}, '
                         f'found {",".join(rows[0]) if rows else "nothing"}')
    return rows[1:]


def _numbers(file: str | Path, rows: list[list[str]]) -> Array:
    """Return rows of two numbers each as a table (K, 2)."""
    try:
        table = np.array([[float(cell) for cell in row] for row in rows])
    except ValueError as error:
        raise ValueError(f'{file}: expected numbers, found: {error}') from error
    if table.ndim != 2 or table.shape[1:] != (2,):
        raise ValueError(f'{file}: expected rows of two numbers, found '
                         f'{"rows of other lengths" if rows else "none"}')
    return table
