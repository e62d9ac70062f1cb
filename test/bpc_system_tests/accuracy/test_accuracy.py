"""The default method on prints of known thickness, compared with accuracy_thresholds.yaml."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
import yaml

from bpc_sim.studies import Row, STUDIES

THRESHOLDS = yaml.safe_load(
    Path(__file__).with_name('accuracy_thresholds.yaml').read_text(encoding='utf-8'))
LINES = THRESHOLDS['lines']
CHECKS = [(line, column) for line, content in LINES.items() for column in content['limits']]


@pytest.fixture(scope='module')
def table() -> Callable[[str], list[Row]]:
    """Return the default method's rows for a line of the thresholds; each study runs once."""

    @cache
    def run(name: str, seeds: int, only: tuple[str, ...]) -> list[Row]:
        study = STUDIES[name]
        chosen = replace(study, tasks=lambda count: [
            task for task in study.tasks(count) if not only or task[0] in only])
        return [row for row in chosen.run(seeds, processes=2) if row['method'] == 'cross_section']

    def rows(line: str) -> list[Row]:
        content = LINES[line]
        wanted = content['rows']
        seeds = content.get('seeds', 1)
        # With more seeds only the scenes of the line; the scene is the first part of a task.
        only = tuple(wanted['scene']) if seeds > 1 else ()
        return [row for row in run(content['study'], seeds, only)
                if all(row[column] in values for column, values in wanted.items())]

    return rows


def label(row: Row) -> str:
    """Return the name of a row in a failure."""
    return row['scene'] if 'scene' in row else f'case_{row["case"]}'


@pytest.mark.accuracy
@pytest.mark.parametrize(('line', 'column'), CHECKS)
def test_accuracy(line: str, column: str, table: Callable[[str], list[Row]]) -> None:
    content = LINES[line]
    rows = table(line)
    assert len(rows) >= max(map(len, content['rows'].values()), default=1)
    least, most = content['limits'][column]
    missed = {label(row): row[column] for row in rows if not least <= row[column] <= most}
    assert missed == {}, f'{line}, {column}: expected {least} to {most}'
