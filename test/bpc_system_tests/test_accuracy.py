"""The default method on prints of known thickness, held against accuracy_thresholds.yaml."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from bpc_sim.studies import Row, STUDIES
import pytest
import yaml

THRESHOLDS = yaml.safe_load(
    Path(__file__).with_name('accuracy_thresholds.yaml').read_text(encoding='utf-8'))
LINES = THRESHOLDS['lines']
NOT_REACHED = THRESHOLDS['not_reached']
MARGIN = 1.2
CHECKS = [(line, column) for line, content in LINES.items() for column in content['limits']]


@pytest.fixture(scope='module')
def table() -> Callable[[str], list[Row]]:
    """From a line to the default method's rows that it is about; each study runs once."""

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
        # With more seeds only what the line is about, which is the first part of a task.
        only = tuple(wanted['scene']) if seeds > 1 else ()
        return [row for row in run(content['study'], seeds, only)
                if all(row[column] in values for column, values in wanted.items())]

    return rows


def label(row: Row) -> str:
    """What not_reached calls a row."""
    return row['scene'] if 'scene' in row else f'case_{row["case"]}'


def holds(value: float, least: float, most: float, known: float | None) -> bool:
    """Whether a value is right, or no worse than is known of it; NaN is not."""
    if least <= value <= most:
        return True
    if known is None:
        return False
    if known > most:
        return least <= value <= MARGIN * known
    return 1 - MARGIN * (1 - known) <= value <= most


@pytest.mark.accuracy
@pytest.mark.parametrize(('line', 'column'), CHECKS)
def test_accuracy(line: str, column: str, table: Callable[[str], list[Row]]) -> None:
    content = LINES[line]
    rows = table(line)
    assert len(rows) >= max(map(len, content['rows'].values()), default=1)
    known: dict[str, Any] = NOT_REACHED.get(line, {})
    least, most = content['limits'][column]
    missed = {label(row): row[column] for row in rows
              if not holds(row[column], least, most, known.get(label(row), {}).get(column))}
    assert missed == {}, f'{line}, {column}: expected {least} to {most}'


def test_what_is_not_reached_is_asked_for() -> None:
    for line, rows in NOT_REACHED.items():
        for row, columns in rows.items():
            for column, value in columns.items():
                least, most = LINES[line]['limits'][column]
                assert not least <= value <= most, (line, row, column)


@pytest.mark.parametrize(('value', 'right'), [
    (0.1, True), (0.11, False), (float('nan'), False)])
def test_a_limit_is_a_limit(value: float, right: bool) -> None:
    assert holds(value, 0, 0.1, None) == right


@pytest.mark.parametrize(('value', 'least', 'most', 'known', 'right'), [
    (0.24, 0, 0.1, 0.2, True), (0.25, 0, 0.1, 0.2, False), (0.09, 0, 0.1, 0.2, True),
    (0.76, 0.9, 1, 0.8, True), (0.75, 0.9, 1, 0.8, False), (float('nan'), 0.9, 1, 0.8, False),
    (0.5, 0.63, 0.73, 0.55, True), (0.8, 0.63, 0.73, 0.55, False)])
def test_what_is_not_reached_gets_no_worse(
        value: float, least: float, most: float, known: float, right: bool) -> None:
    assert holds(value, least, most, known) == right
