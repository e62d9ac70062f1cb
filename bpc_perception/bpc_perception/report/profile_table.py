"""The table profile.csv: one sample a line, lengths in millimetres."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.design.comparison import DesignComparison
from bpc_perception.core.profile import Cause, Status, ThicknessProfile
from bpc_perception.display.units import M_PER_MM, MM_PER_M, NS_PER_S

COLUMNS = ('arc_length_mm', 'time_s', 'x_mm', 'y_mm', 'z_mm', 'thickness_mm', 'sigma_mm',
           'left_mm', 'right_mm', 'status', 'extruding', 'stroke', 'layer', 'height_mm',
           'height_sigma_mm', 'area_mm2', 'area_sigma_mm2', 'capture', 'cause')
# Where a design is told.
WANTED = 'wanted_mm'
DESIGN_COLUMNS = ('design_stroke', WANTED, 'nozzle_off_mm', 'bead_off_mm')


def profile_csv(profile: ThicknessProfile, design: DesignComparison | None = None) -> str:
    """Return the profile as CSV with a header; an empty cell = not known.

    Beside its design it has columns more. Numbers have as many digits as it takes to read the
    same number back.
    """
    told = np.isin(profile.status, (Status.MEASURED, Status.GAP))
    columns = [
        _cells(profile.arc_length * MM_PER_M),
        [_seconds(profile.print_start_ns + round(time * NS_PER_S))
         for time in profile.time.tolist()],
        *(_cells(axis * MM_PER_M) for axis in profile.points.T),
        _cells(np.where(told, profile.thickness, np.nan) * MM_PER_M),
        *(_cells(values * MM_PER_M) for values in (profile.sigma, profile.left, profile.right)),
        [Status(value).name for value in profile.status],
        [str(int(on)) if known else '' for on, known in zip(
            profile.extruding.tolist(), profile.extruder_known.tolist(), strict=True)],
        [str(number) for number in profile.stroke.tolist()],
        _numbers(profile.layer),
        *(_cells(values * MM_PER_M) for values in (profile.height, profile.height_sigma)),
        *(_cells(values * MM_PER_M**2) for values in (profile.area, profile.area_sigma)),
        _numbers(profile.seen_in),
        ['' if value == Cause.NONE else Cause(value).name for value in profile.cause]]
    names: tuple[str, ...] = COLUMNS
    if design is not None:
        names, columns = (*COLUMNS, *DESIGN_COLUMNS), [*columns, *_design_cells(profile, design)]
    rows = (names, *zip(*columns, strict=True))
    return ''.join(','.join(row) + '\n' for row in rows)


def _design_cells(profile: ThicknessProfile, design: DesignComparison) -> list[list[str]]:
    """Return the columns that tell where each sample is beside the design."""
    found, pieces = design.deviations, design.pieces
    if found is None or pieces is None:
        return [[''] * len(profile)] * len(DESIGN_COLUMNS)
    stroke = np.where(found.piece >= 0, pieces.stroke[found.piece] + 1, -1)
    return [_numbers(stroke), *(_cells(values * MM_PER_M) for values in (
        found.width, found.nozzle, found.bead))]


def read_profile(file: Path, print_id: str = '') -> ThicknessProfile:
    """Return the profile that a table holds.

    What the table does not tell is NaN: side points, the volume that was commanded, the shift.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is no such table; the message names what was expected and found.
    """
    try:
        with file.open(encoding='utf-8', newline='') as stream:
            reader = csv.DictReader(stream)
            rows = list(reader)
        if missing := set(COLUMNS) - set(reader.fieldnames or ()):
            raise KeyError(min(missing))
        return _profile_of({name: [row[name] for row in rows] for name in COLUMNS}, print_id)
    except (csv.Error, KeyError, TypeError, UnicodeDecodeError, ValueError) as error:
        raise ValueError(f'{file}: expected a profile as bpc writes it, found: {error!r}'
                         '; measure it again') from error


def read_wanted(file: Path) -> Array | None:
    """Return the width (N,) that the design wants at each sample of a table [m].

    NaN = it tells none there; None = there is no design. Raises as ``read_profile``.
    """
    try:
        with file.open(encoding='utf-8', newline='') as stream:
            reader = csv.DictReader(stream)
            if WANTED not in (reader.fieldnames or ()):
                return None
            return np.array([float(row[WANTED] or 'nan') for row in reader]) * M_PER_MM
    except (csv.Error, TypeError, UnicodeDecodeError, ValueError) as error:
        raise ValueError(f'{file}: expected a profile as bpc writes it, found: {error!r}'
                         '; measure it again') from error


def _profile_of(cells: dict[str, list[str]], print_id: str) -> ThicknessProfile:
    """Return the profile of a table whose columns are cells (N,) in words."""
    def lengths(name: str, power: int = 1) -> Array:
        return np.array([float(cell or 'nan') for cell in cells[name]]) * M_PER_MM**power

    def numbers(name: str, none: int) -> Index:
        return np.array([int(cell or none) for cell in cells[name]], np.intp)

    stamps = [_stamp_ns(cell) for cell in cells['time_s']]
    start = stamps[0] if stamps else 0
    count = len(stamps)
    status = np.array([Status[name] for name in cells['status']], np.uint8)
    unknown, no_places = np.full(count, np.nan), np.full((count, 3), np.nan)
    seen_in = numbers('capture', -1)
    return ThicknessProfile(
        stamp_ns=max(stamps, default=0), print_id=print_id, print_start_ns=start,
        capture=int(seen_in.max(initial=0)), method='',
        time=np.array([stamp - start for stamp in stamps]) / NS_PER_S,
        arc_length=lengths('arc_length_mm'),
        points=np.stack([lengths(name) for name in ('x_mm', 'y_mm', 'z_mm')], axis=1),
        extruding=numbers('extruding', 0) > 0,
        extruder_known=np.array([cell != '' for cell in cells['extruding']], bool),
        stroke=numbers('stroke', 0), status=status, thickness=lengths('thickness_mm'),
        sigma=lengths('sigma_mm'), left=lengths('left_mm'), right=lengths('right_mm'),
        left_points=no_places, right_points=no_places, layer=numbers('layer', -1),
        height=lengths('height_mm'), height_sigma=lengths('height_sigma_mm'),
        area=lengths('area_mm2', 2), area_sigma=lengths('area_sigma_mm2', 2), seen_in=seen_in,
        commanded_area=unknown,
        cause=np.array([Cause[name or 'NONE'] for name in cells['cause']], np.uint8),
        shift=np.full(3, np.nan), tip_height=np.nan, processing_time=np.nan)


def _cells(values: Array) -> list[str]:
    return ['' if math.isnan(value) else repr(value) for value in values.tolist()]


def _numbers(values: Index) -> list[str]:
    """Return numbers (N,) in words; -1 = none."""
    return ['' if value < 0 else str(value) for value in values.tolist()]


def _seconds(stamp_ns: int) -> str:
    """Return nanoseconds as seconds, to the last digit."""
    whole, rest_ns = divmod(stamp_ns, NS_PER_S)
    return f'{whole}.{rest_ns:09d}'


def _stamp_ns(seconds: str) -> int:
    """Return seconds in words, as ``_seconds`` writes them, as nanoseconds."""
    whole, _, rest = seconds.partition('.')
    return int(whole) * NS_PER_S + int(rest.ljust(9, '0'))
