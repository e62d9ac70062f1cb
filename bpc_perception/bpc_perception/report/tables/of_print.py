"""The profile of a print, its strokes and its layers as tables for other programs."""

from __future__ import annotations

from collections.abc import Sequence
import csv
from typing import Any

from bpc_perception.core.design.comparison import DesignComparison
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.display.plain_json import plain
from bpc_perception.report.entries import layer_entries, stroke_entries
from bpc_perception.report.profile_table import profile_csv
from bpc_perception.report.tables.table import Column, Table

PROFILE = (
    Column('arc_length_mm', float, 'arc length along the path from its first point'),
    Column('time_s', float, 'when the nozzle passed, since 1970 UTC'),
    *(Column(f'{axis}_mm', float, f'{axis} of the nozzle tip in the robot base frame')
      for axis in 'xyz'),
    Column('thickness_mm', float, 'width of the filament; 0 in a gap'),
    Column('sigma_mm', float, 'standard deviation of the thickness'),
    Column('left_mm', float, 'from the path to the left side point'),
    Column('right_mm', float, 'from the path to the right side point'),
    Column('status', str, 'what is known of the sample'),
    Column('extruding', int, '1 where ink was commanded, 0 where not'),
    Column('stroke', int, 'number of the stroke, from 1; 0 = travel'),
    Column('layer', int, 'number of the layer, 0 = on the bed'),
    Column('height_mm', float, 'height of the ink above what lay there before'),
    Column('height_sigma_mm', float, 'standard deviation of the height'),
    Column('area_mm2', float, 'cross-section of the ink above what lay there before'),
    Column('area_sigma_mm2', float, 'standard deviation of the cross-section'),
    Column('capture', int, 'number of the capture in which it was found so'),
    Column('cause', str, 'why it has no answer'))
DESIGN = (
    Column('design_stroke', int, "number of the design's stroke, from 1"),
    Column('wanted_mm', float, 'width that the design wants'),
    Column('nozzle_off_mm', float, 'how far the nozzle passed to the left of the design'),
    Column('bead_off_mm', float, "how far the filament's middle lies to its left"))
AMOUNT = (
    Column('length_mm', float, 'length of path on which ink was commanded'),
    Column('known', float, 'share of it whose cross-section is known'),
    Column('thickness_mean_mm', float, 'mean width'),
    Column('height_mean_mm', float, 'mean height'),
    Column('area_mean_mm2', float, 'mean cross-section'),
    Column('volume_mm3', float, 'volume of the ink'),
    Column('volume_sigma_mm3', float, 'standard deviation of the volume'),
    Column('commanded_mm3', float, 'volume that was commanded'),
    Column('delivered', float, 'volume as a share of what was commanded'),
    Column('delivered_sigma', float, 'standard deviation of this share'))
STROKES = (
    Column('stroke', int, 'number of the stroke, from 1'),
    Column('start_mm', float, 'arc length at which ink was commanded'),
    Column('end_mm', float, 'arc length up to which ink was commanded'),
    Column('ink_start_mm', float, 'arc length at which the ink begins'),
    Column('ink_end_mm', float, 'arc length at which the ink ends'),
    Column('start_lag_mm', float, 'how late the ink begins'),
    Column('end_lag_mm', float, 'how late the ink ends'),
    Column('layer', int, 'number of the layer, 0 = on the bed'), *AMOUNT)
LAYERS = (Column('layer', int, 'number of the layer, 0 = on the bed'), *AMOUNT,
          Column('gap_count', int, 'number of gaps'),
          Column('gap_length_mm', float, 'their length together'))


def result_tables(profile: ThicknessProfile,
                  design: DesignComparison | None = None) -> tuple[Table, Table, Table]:
    """Return the tables of a print: the same numbers as in profile.csv and summary.json."""
    lines = csv.DictReader(profile_csv(profile, design).splitlines())
    columns = PROFILE if design is None else (*PROFILE, *DESIGN)
    return (Table('profile', columns, [_numbers(line, columns) for line in lines]),
            Table('strokes', STROKES, _plain(stroke_entries(profile))),
            Table('layers', LAYERS, _plain(layer_entries(profile))))


def _numbers(line: dict[str, str], columns: Sequence[Column]) -> dict[str, Any]:
    return {column.name: column.kind(line[column.name]) if line[column.name] else None
            for column in columns}


def _plain(entries: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = plain(list(entries))
    return rows
