"""The table profile.csv: one sample a line, lengths in millimetres."""

from __future__ import annotations

import math

import numpy as np

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.profile import Cause, Status, ThicknessProfile
from bpc_perception.display.units import MM_PER_M, NS_PER_S

COLUMNS = ('arc_length_mm', 'time_s', 'x_mm', 'y_mm', 'z_mm', 'thickness_mm', 'sigma_mm',
           'left_mm', 'right_mm', 'status', 'extruding', 'stroke', 'layer', 'height_mm',
           'height_sigma_mm', 'area_mm2', 'area_sigma_mm2', 'capture', 'cause')


def profile_csv(profile: ThicknessProfile) -> str:
    """Return the profile as CSV with a header; an empty cell = not known.

    Numbers have as many digits as it takes to read the same number back.
    """
    told = np.isin(profile.status, (Status.MEASURED, Status.GAP))
    columns = (
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
        ['' if value == Cause.NONE else Cause(value).name for value in profile.cause])
    rows = (COLUMNS, *zip(*columns, strict=True))
    return ''.join(','.join(row) + '\n' for row in rows)


def _cells(values: Array) -> list[str]:
    return ['' if math.isnan(value) else repr(value) for value in values.tolist()]


def _numbers(values: Index) -> list[str]:
    """Return numbers (N,) in words; -1 = none."""
    return ['' if value < 0 else str(value) for value in values.tolist()]


def _seconds(stamp_ns: int) -> str:
    """Return nanoseconds as seconds, to the last digit."""
    whole, rest_ns = divmod(stamp_ns, NS_PER_S)
    return f'{whole}.{rest_ns:09d}'
