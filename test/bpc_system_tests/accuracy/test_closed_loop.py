"""The advice on prints that go wrong, compared with closed_loop_thresholds.yaml.

These tests try a few printers of each scenario; `bpc study closedloop` tries twenty.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from bpc_sim.closed_loop.situations import SITUATIONS
from bpc_sim.studies import Row, STUDIES

THRESHOLDS = yaml.safe_load(
    Path(__file__).with_name('closed_loop_thresholds.yaml').read_text(encoding='utf-8'))
LINES, BETTER = THRESHOLDS['lines'], THRESHOLDS['better_than']
MORE = THRESHOLDS['more_prints']
LEARNED = THRESHOLDS['third_layer']
pytestmark = pytest.mark.timeout(600)  # the first test waits for all prints
CHECKS = [(line, column) for line, content in LINES.items() for column in content['limits']]


@pytest.fixture(scope='module')
def table() -> dict[tuple[str, str], Row]:
    """The rows of the study by scenario and controller, of single layers."""
    study = replace(STUDIES['closedloop'], tasks=lambda few: [
        (name, seed, ()) for name in SITUATIONS
        for seed in range(MORE['prints'] if name in MORE['scenarios'] else few)])
    # One process: other tests run beside these, and some of them watch the clock.
    rows = study.run(THRESHOLDS['prints'], processes=1)
    return {(row['scenario'], row['controller']): row for row in rows}


@pytest.fixture(scope='module')
def third_layers() -> dict[str, Row]:
    """The rows of the third layers that learning makes, by scenario."""
    study = replace(STUDIES['closedloop'], tasks=lambda few: [
        (name, seed, ('learned',)) for name in LEARNED['scenarios'] for seed in range(few)])
    rows = study.run(LEARNED['prints'], processes=1)
    return {row['scenario']: row for row in rows
            if (row['controller'], row['layer']) == ('learned', 3)}


@pytest.mark.accuracy
@pytest.mark.parametrize('name', LEARNED['scenarios'])
def test_the_third_layer(name: str, third_layers: dict[str, Row]) -> None:
    assert third_layers[name]['rms_ratio'] <= LEARNED['scenarios'][name]


@pytest.mark.accuracy
@pytest.mark.parametrize(('line', 'column'), CHECKS)
def test_closed_loop(line: str, column: str, table: dict[tuple[str, str], Row]) -> None:
    content: dict[str, Any] = LINES[line]
    least, most = content['limits'][column]
    scenarios = list(SITUATIONS) if content['scenarios'] == ['every'] else content['scenarios']
    rows = {(name, controller): table[name, controller][column]
            for name in scenarios for controller in content['controllers']}
    missed = {key: value for key, value in rows.items()
              if not least - 1e-9 <= value <= most + 1e-9}
    assert missed == {}, f'{line}, {column}: expected {least} to {most}'


def compared(table: dict[tuple[str, str], Row], other: str, scenarios: list[str]) -> dict[
        str, float]:
    return {name: table[name, 'advice']['rms_percent'] / table[name, other]['rms_percent']
            for name in scenarios}


@pytest.mark.accuracy
def test_better_than_the_mass_balance_at_every_capture(
        table: dict[tuple[str, str], Row]) -> None:
    without_fault = [name for part in BETTER['pi'].values() for name in part['scenarios']]
    most = BETTER['mass_balance']['every_scenario_without_a_fault']
    missed = {name: value for name, value in compared(
        table, 'mass_balance', without_fault).items() if value > most}
    assert missed == {}


@pytest.mark.accuracy
@pytest.mark.parametrize('part', list(BETTER['pi']))
def test_no_worse_than_a_tuned_pi(part: str, table: dict[tuple[str, str], Row]) -> None:
    content = BETTER['pi'][part]
    missed = {name: value for name, value in compared(
        table, 'pi', content['scenarios']).items() if value > content['most']}
    assert missed == {}


def test_every_scenario_is_asked_for_something() -> None:
    named = {name for content in LINES.values() for name in content['scenarios']}
    named |= {name for part in BETTER['pi'].values() for name in part['scenarios']}
    named |= set(LEARNED['scenarios'])
    assert named - {'every'} == set(SITUATIONS)
