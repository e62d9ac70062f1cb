"""Pictures by a ray tracer, kept in files, compared with raytraced_thresholds.yaml."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from bpc_sim.raytraced.spec import Half
from bpc_sim.studies import Row, STUDIES

THRESHOLDS = yaml.safe_load(
    Path(__file__).with_name('raytraced_thresholds.yaml').read_text(encoding='utf-8'))
pytestmark = [pytest.mark.accuracy, pytest.mark.timeout(300)]


@pytest.fixture(scope='module')
def table() -> list[Row]:
    """A row of each scene, and of each half together."""
    return STUDIES['raytraced'].run(processes=1)


def outside(row: Row, thresholds: dict[str, tuple[float, float]]) -> Row:
    """The columns of a row that are not within their thresholds."""
    return {column: row[column] for column, (least, most) in thresholds.items()
            if not least <= row[column] <= most}


@pytest.mark.parametrize('half', [half.value for half in Half])
def test_pictures_that_the_suite_does_not_draw_are_measured(half: str, table: list[Row]) -> None:
    row, = (row for row in table if (row['scene'], row['half']) == ('all', half))
    assert row['samples'] > 10_000
    assert outside(row, THRESHOLDS[half]) == {}


def test_each_scene_is_measured(table: list[Row]) -> None:
    scenes = [row for row in table if row['scene'] != 'all']
    assert len(scenes) == 48
    found = {row['scene']: outside(row, THRESHOLDS['each']) for row in scenes}
    assert {name: columns for name, columns in found.items() if columns} == {}
