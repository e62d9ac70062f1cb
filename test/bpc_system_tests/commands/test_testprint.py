"""`bpc testprint` as a user runs it: write, print in the simulator, judge."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from bpc_system_tests.parts.command_line import refusal, succeed

pytestmark = [pytest.mark.system]

FOR = '--nozzle-mm', 1, '--bed-mm', '100,100'
FLOWS, SPEEDS = (4, 7), (6, 12)
SPREADING = 1.5


@pytest.fixture(scope='module')
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep that was written, printed and judged."""
    there = tmp_path_factory.mktemp('testprint')
    succeed('testprint', 'lines', '--out', there, *FOR, '--flows-mm3-s', '4,7',
            '--speeds-mm-s', '6,12', '--quiet')
    succeed('sim', '--design', there / 'lines.csv', '--record', there / 'bag', '--rate', 0.03,
            '--spreading', SPREADING, '--dead-time', 0.2, '--lag', 0.001, '--quiet')
    (there / 'said.txt').write_text(succeed(
        'testprint', 'judge', there / 'bag', '--strokes', there / 'lines_strokes.csv',
        '--out', there / 'judged'))
    return there


def rows_of(file: Path) -> list[dict[str, str]]:
    with file.open(encoding='utf-8', newline='') as stream:
        return list(csv.DictReader(stream))


def test_the_sweep_follows_the_law_of_the_ink(folder: Path) -> None:
    text = (folder / 'judged' / 'sweep.csv').read_text()
    assert text.splitlines()[0] == (
        'line,flow_mm3_s,speed_mm_s,pressure_kpa,temperature_c,width_mm,width_sigma_mm,'
        'height_mm,height_sigma_mm,area_mm2,area_sigma_mm2,samples,start_lag_s,stop_lag_s')
    rows = rows_of(folder / 'judged' / 'sweep.csv')
    assert [int(row['line']) for row in rows] == [2, 3, 4, 5, 6, 7]
    pairs = [(float(row['flow_mm3_s']), float(row['speed_mm_s'])) for row in rows[1:-1]]
    assert sorted(pairs) == [(flow, speed) for flow in FLOWS for speed in SPEEDS]
    for row in rows:
        area = float(row['flow_mm3_s']) / float(row['speed_mm_s'])
        width = SPREADING * np.sqrt(4 / np.pi * area)
        # Ink varies by 2 % along a line, from one millimetre to the next.
        assert float(row['width_mm']) == pytest.approx(width, rel=0.05)
        assert float(row['area_mm2']) == pytest.approx(area, rel=0.15)
        assert row['pressure_kpa'] == row['temperature_c'] == ''
        assert float(row['start_lag_s']) == pytest.approx(0.2, abs=0.06)


def test_the_planted_lag_is_found(folder: Path) -> None:
    found = {row['quantity']: row for row in rows_of(folder / 'judged' / 'findings.csv')
             if row['of'] == 'print'}
    assert set(found) == {'start_lag', 'stop_lag', 'drift_of_width'}
    for name in ('start_lag', 'stop_lag'):
        assert float(found[name]['value']) == pytest.approx(
            0.2, abs=3 * float(found[name]['sigma']))
        assert float(found[name]['sigma']) < 0.04
        assert found[name]['unit'] == 's'


def test_it_is_said(folder: Path) -> None:
    text = (folder / 'said.txt').read_text()
    for word in ('start lag [s]', 'drift_of_width', 'width [mm]', '±'):
        assert word in text


def test_nothing_is_written_over(folder: Path) -> None:
    assert 'expected no findings.csv there, found one' in refusal(
        'testprint', 'judge', folder / 'bag', '--strokes', folder / 'lines_strokes.csv',
        '--out', folder / 'judged')
