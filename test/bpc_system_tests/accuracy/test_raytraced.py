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
def table() -> dict[str, Row]:
    """The row of all scenes together, of each half."""
    return {row['half']: row for row in STUDIES['raytraced'].run(processes=1)
            if row['scene'] == 'all'}


@pytest.mark.parametrize('half', [half.value for half in Half])
def test_pictures_that_the_suite_does_not_draw_are_measured(
        half: str, table: dict[str, Row]) -> None:
    row = table[half]
    assert row['samples'] > 10_000
    outside = {column: row[column] for column, (least, most) in THRESHOLDS[half].items()
               if not least <= row[column] <= most}
    assert outside == {}
