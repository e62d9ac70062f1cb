"""Two or more prints beside each other, from the files that were written about them."""

from __future__ import annotations

from collections.abc import Sequence
import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.inspection.verdict import Verdict
from bpc_perception.core.profile import Status
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.verdict_words import NAMES
from bpc_perception.report.entries import design_numbers
from bpc_perception.report.result_folder import expect_summary, part_of, SUMMARY
from bpc_perception.report.tables.table import Column as TableColumn, Table


@dataclass(frozen=True)
class Column:
    """A column of the table.

    Attributes:
        key: of summary.json.
        heading: with the unit.
        digits: behind the point.
        factor: from the unit of summary.json to that of the heading.
    """

    key: str
    heading: str
    digits: int
    factor: int = 1

    def cell(self, value: float | None) -> str:
        """Return a value of summary.json in words; a dash for none."""
        return '-' if value is None else f'{self.factor * value:.{self.digits}f}'


COLUMNS = (
    Column('path_length_mm', 'path [mm]', 1),
    Column('target_mm', 'target [mm]', 3),
    Column('thickness_mean_mm', 'mean [mm]', 3),
    Column('thickness_std_mm', 'std. [mm]', 3),
    Column('thickness_q1_mm', 'Q1 [mm]', 3),
    Column('thickness_median_mm', 'Q2 [mm]', 3),
    Column('thickness_q3_mm', 'Q3 [mm]', 3),
    Column('thickness_variation', 'variation [%]', 1, 100),
    Column('within_10_percent', 'within ±10 % [%]', 1, 100),
    Column('coverage', 'known [%]', 1, 100),
    Column('gap_count', 'gaps', 0),
    Column('gap_length_mm', 'gaps [mm]', 1),
    Column('offset_rms_mm', 'offset RMS [mm]', 3),
    Column('design_off_mm', 'off design, 95 % [mm]', 3),
    Column('layer_fidelity', 'layer fidelity [%]', 1, 100),
)


LAYER_COLUMNS = (
    Column('length_mm', 'ink [mm]', 1),
    Column('known', 'known [%]', 1, 100),
    Column('thickness_mean_mm', 'width [mm]', 3),
    Column('height_mean_mm', 'height [mm]', 3),
    Column('area_mean_mm2', 'area [mm²]', 3),
    Column('volume_mm3', 'volume [mm³]', 1),
    Column('volume_sigma_mm3', '± [mm³]', 1),
    Column('delivered', 'delivered [%]', 1, 100),
    Column('gap_count', 'gaps', 0),
)


@dataclass(frozen=True)
class PrintResult:
    """The result of a print, as its files say.

    Attributes:
        name: distinguishes it from the others.
        summary: content of summary.json.
        arc_length: (N,) [mm].
        thickness: (N,) [mm]; NaN = not known.
        measured, gap: (N,) where the status is MEASURED and GAP.
    """

    name: str
    summary: dict[str, Any]
    arc_length: Array
    thickness: Array
    measured: NDArray[np.bool_]
    gap: NDArray[np.bool_]

    @property
    def target_mm(self) -> float | None:
        """The thickness wanted all along [mm]; None = none, or one that changes along the path."""
        settings = part_of(self.summary, 'settings')
        target = settings.get('advice.target_thickness')
        if not isinstance(target, float) or not target or settings.get('advice.target_file'):
            return None
        return target * MM_PER_M

    @property
    def verdict(self) -> str:
        """Whether it is good, in words; a dash where its summary is of another version."""
        said = str(part_of(self.summary, 'verdict').get('verdict'))
        return NAMES[Verdict[said]] if said in Verdict.__members__ else '-'


def load(folders: Sequence[Path]) -> list[PrintResult]:
    """Read the results in these folders; a print is named like its folder.

    A folder of several prints stands for all of them. Where folders have the same name the prints
    are named by their paths.

    Raises:
        ValueError: a folder holds no result, or there is but one print; the message names what
            was expected and found.
    """
    folders = [place for folder in folders for place in _prints_in(folder)]
    if len(folders) < 2:
        raise ValueError('compare: expected two prints or more, found one'
                         '; name the folders of two results')
    short = [folder.absolute().name for folder in folders]
    names = short if len(set(short)) == len(short) else [str(folder) for folder in folders]
    return [_load(folder, name) for folder, name in zip(folders, names, strict=True)]


def _prints_in(folder: Path) -> list[Path]:
    """Return the folders of prints that the summary in a folder lists, or the folder itself."""
    file = folder / SUMMARY
    prints = expect_summary(folder).get('prints') if file.is_file() else None
    try:
        return [folder / each['folder'] for each in prints] if prints else [folder]
    except (LookupError, TypeError) as error:
        raise ValueError(f'{file}: expected prints with their folders, found: {error}'
                         '; measure it again') from error


def _load(folder: Path, name: str) -> PrintResult:
    for file in ('profile.csv', SUMMARY):
        if not (folder / file).is_file():
            raise ValueError(f'{folder}: expected a folder with profile.csv and summary.json, '
                             f'found no {file}; name one that "bpc measure" wrote')
    summary = _read_summary(folder)
    arc_length, thickness, status = _read_profile(folder / 'profile.csv')
    return PrintResult(name, summary, arc_length, thickness, status == Status.MEASURED,
                       status == Status.GAP)


def _read_summary(folder: Path) -> dict[str, Any]:
    summary, file = expect_summary(folder), folder / SUMMARY
    missing = [key for key in ('print_id', 'thickness_mean_mm') if key not in summary]
    if missing:
        raise ValueError(f'{file}: expected {missing[0]}, found none; measure it again')
    return summary


def _read_profile(file: Path) -> tuple[Array, Array, NDArray[np.uint8]]:
    """Return arc length [mm], thickness [mm] (NaN = not known) and status, (N,) each."""
    try:
        with file.open(encoding='utf-8', newline='') as stream:
            samples = list(csv.DictReader(stream))
        arc_length, thickness = (np.array([float(sample[key] or 'nan') for sample in samples])
                                 for key in ('arc_length_mm', 'thickness_mm'))
        status = np.array([Status[sample['status']] for sample in samples], np.uint8)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f'{file}: expected a profile as bpc writes it, '
                         f'found: {error!r}; measure it again') from error
    return arc_length, thickness, status


def rows(prints: Sequence[PrintResult]) -> list[dict[str, Any]]:
    """Return a flat row for each print, with the keys of summary.json."""
    return [{'print': print_.name,
             **{column.key: print_.summary.get(column.key) for column in COLUMNS},
             'target_mm': print_.target_mm, 'verdict': print_.verdict,
             **design_numbers(print_.summary)}
            for print_ in prints]


def compared_table(print_rows: Sequence[dict[str, Any]]) -> Table:
    """Return the rows of prints as a table for other programs."""
    return Table('prints', (
        TableColumn('print', str, 'name of the print'),
        TableColumn('verdict', str, 'whether it is good'),
        *(TableColumn(column.key, float, column.heading.partition(' [')[0])
          for column in COLUMNS)), print_rows)


def layer_rows(prints: Sequence[PrintResult]) -> list[tuple[int, int, list[str]]]:
    """Return number of the layer, number of the print, and numbers in words, layer by layer.

    Nothing where no print has more than one layer and no volume is known.
    """
    found = [(int(layer['layer']), number, layer) for number, print_ in enumerate(prints)
             for layer in print_.summary.get('layers') or []]
    told = any(layer > 0 or values.get('volume_mm3') is not None for layer, _, values in found)
    return [(layer, number, [column.cell(values.get(column.key)) for column in LAYER_COLUMNS])
            for layer, number, values in sorted(found, key=lambda row: row[:2])] if told else []


def cells(row: dict[str, Any]) -> list[str]:
    """Return a row in words: the name of the print, and numbers in the units of the headings."""
    return [row['print'], row['verdict'],
            *(column.cell(row[column.key]) for column in COLUMNS)]


def differences(prints: Sequence[PrintResult]) -> list[tuple[str, list[str]]]:
    """Return what the prints were measured with and that is not alike: names and values."""
    conditions = [
        {'recording': print_.summary.get('bag'), 'capture': print_.summary.get('capture'),
         'hand-eye calibration': print_.summary.get('hand_eye'),
         **print_.summary.get('versions', {}), **print_.summary.get('settings', {})}
        for print_ in prints]
    names = dict.fromkeys(name for condition in conditions for name in condition)
    values = [(name, [str(condition.get(name, '-')) for condition in conditions])
              for name in names]
    return [(name, each_print) for name, each_print in values if len(set(each_print)) > 1]
