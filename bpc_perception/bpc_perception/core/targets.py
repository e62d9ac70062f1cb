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
            raise ValueError(f'{file}: expected arc lengths in order, found others; sort its rows')
        outside = table[(thickness < LEAST_TARGET_M) | (thickness > LARGEST_TARGET_M), 1]
        if len(outside):
            least, most = (limit / MILLIMETRE_M for limit in (LEAST_TARGET_M, LARGEST_TARGET_M))
            raise ValueError(f'{file}: expected thicknesses from {least:g} to {most:g} mm, '
                             f'found {outside[0]:g}; are they in millimetres?')
        return cls(arc_length, thickness)

    @classmethod
    def wanted(cls, table: WidthTargets | None, thickness: float) -> WidthTargets | None:
        """Return a table, else the same thickness [m] everywhere; None where that is 0."""
        return table or (cls.constant(thickness) if thickness else None)

    @classmethod
    def told(cls, arc_length: Array, thickness: Array,
             others: WidthTargets | None) -> WidthTargets | None:
        """Return targets of a thickness (N,) told at places (N,), others where it is NaN [m]."""
        if others is not None:
            thickness = np.where(np.isnan(thickness), others.at(arc_length), thickness)
        known = ~np.isnan(thickness)
        return cls(arc_length[known], thickness[known]) if known.any() else others

    def at(self, arc_length: Array | float) -> Array:
        """Return the thickness (...) at these arc lengths (...) [m]."""
        return np.asarray(np.interp(arc_length, self.arc_length, self.thickness))


def _rows(file: str | Path) -> list[tuple[int, list[str]]]:
    """Read the rows of a table below its columns, each with the number of its line."""
    with Path(file).open('rb') as stream:
        content = stream.read(LARGEST_BYTES + 1)
    if len(content) > LARGEST_BYTES:
        raise ValueError(f'{file}: expected at most {LARGEST_BYTES} bytes, found more; is it the '
                         'right file?')
    try:
        reader = csv.reader(content.decode('utf-8-sig').splitlines())
        rows = [(reader.line_num, row) for row in reader if row]
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f'{file}: expected a table as CSV in UTF-8, found: {error}'
                         '; save it as that') from error
    heading = [cell.strip() for cell in rows[0][1]] if rows else ['nothing']
    if heading != COLUMNS:
        raise ValueError(f'{file}: expected the columns {",".join(COLUMNS)} in its first line, '
                         f'found {",".join(heading)}')
    return rows[1:]


def _numbers(file: str | Path, rows: list[tuple[int, list[str]]]) -> Array:
    """Return rows of two numbers each as a table (K, 2)."""
    if not rows:
        raise ValueError(f'{file}: expected rows of two numbers, found none; write one at least')
    table = np.empty((len(rows), len(COLUMNS)))
    for index, (line, row) in enumerate(rows):
        try:
            arc_length, thickness = map(float, row)
            table[index] = arc_length, thickness
        except ValueError:
            raise ValueError(f'{file}: expected two numbers with points, found '
                             f'{",".join(row)!r} in line {line}; correct it') from None
    return table
