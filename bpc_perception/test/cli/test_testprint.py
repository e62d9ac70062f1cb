"""`bpc testprint`: what its options make, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from testprint_builders import Ink, printed

from bpc_perception.cli.app import command_line
from bpc_perception.files import sweep_table
from bpc_perception.files.settings_file import settings_file
from bpc_perception.files.testprints.stroke_table import read_test_print
from bpc_perception.report.profile_table import profile_csv

FOR = '--nozzle-mm', '1', '--bed-mm', '100,100'


def run(*words: object) -> None:
    texts = ['testprint', *map(str, words)]
    command_line(texts)(texts, standalone_mode=False)


@pytest.mark.parametrize('name', [
    'lines', 'fusion', 'turns', 'lattice', 'line-over-lines', 'wall'])
def test_each_is_written(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(name, '--out', tmp_path, '--nozzle-mm', 0.41, '--bed-mm', '60,60', '--plunger-mm', 26.7)
    files = f'{name}.csv', f'{name}.gcode', f'{name}_strokes.csv'
    assert {path.name for path in tmp_path.iterdir()} == set(files)
    assert read_test_print(tmp_path / files[2]).name == name
    said = capsys.readouterr().out
    assert 'mm3 of ink' in said
    assert all(str(tmp_path / file) in said for file in files)


def test_what_is_told_is_what_is_written(tmp_path: Path) -> None:
    run('lines', '--out', tmp_path, *FOR, '--flows-mm3-s', '4,7', '--speeds-mm-s', '6,12',
        '--length-mm', 40, '--layer-height-mm', 0.6)
    test = read_test_print(tmp_path / 'lines_strokes.csv')
    told = sorted((round(plan.flow * 1e9, 6), round(plan.speed * 1e3, 6))
                  for plan in test.plans[2:-1])
    assert told == [(4, 6), (4, 12), (7, 6), (7, 12)]
    for stroke in test.design.strokes[1:]:
        assert stroke.length == pytest.approx(0.04)
        assert stroke.points[:, 2] == pytest.approx(0.6e-3)
    run('turns', '--out', tmp_path, *FOR, '--angles-deg', '45', '--radii-mm', '3',
        '--speed-mm-s', 5)
    plans = read_test_print(tmp_path / 'turns_strokes.csv').plans[1:]
    assert [round(float(np.degrees(plan.angle))) for plan in plans] == [45, 90]
    assert [plan.radius for plan in plans] == pytest.approx([0, 3e-3])
    assert {plan.speed for plan in plans} == {5e-3}


@pytest.mark.parametrize('name', ['fusion', 'turns', 'lattice', 'line-over-lines', 'wall'])
def test_the_settings_of_a_window_are_printed(name: str, tmp_path: Path) -> None:
    settings = tmp_path / 'next_print.yaml'
    settings.write_text(settings_file(
        {'flow_mm3_s': 5.4, 'speed_mm_s': 9.2, 'temperature_c': 21.0}, 1.3e-3, 0.1, None))
    run(name, '--out', tmp_path, *FOR, '--settings', settings)
    test = read_test_print(tmp_path / f'{name}_strokes.csv')
    for stroke, plan in zip(test.design.strokes, test.plans, strict=True):
        assert stroke.widths == pytest.approx(1.3e-3)
        assert [plan.flow, plan.speed, plan.temperature] == pytest.approx([5.4e-9, 9.2e-3, 21])
    with pytest.raises(ValueError, match='found --speed-mm-s; leave one out'):
        run(name, '--out', tmp_path / 'new', *FOR, '--settings', settings, '--speed-mm-s', 5)


def test_a_result_is_judged(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run('fusion', '--out', tmp_path, *FOR, '--distances-mm', '1,1.4,2')
    test = read_test_print(tmp_path / 'fusion_strokes.csv')
    result = tmp_path / 'result'
    result.mkdir()
    (result / 'profile.csv').write_text(profile_csv(printed(test, Ink(1.2e-3), spacing=2e-4)))
    (result / 'summary.json').write_text('{"print_id": "test"}')
    run('judge', result, '--strokes', tmp_path / 'fusion_strokes.csv', '--design-at', '0,0,0,0',
        '--out', result)
    said = capsys.readouterr().out
    assert 'fusing_distance' in said
    row = (result / 'findings.csv').read_text().splitlines()[1]
    assert row.split(',')[3:5] == ['fusing_distance', '1.2']  # between 1 and 1.4
    with pytest.raises(ValueError, match=r'expected no findings\.csv there'):
        run('judge', result, '--strokes', tmp_path / 'fusion_strokes.csv', '--out', result)


def test_scripts_are_told_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run('lines', '--out', tmp_path, *FOR, '--flows-mm3-s', '4', '--speeds-mm-s', '6,12')
    test = read_test_print(tmp_path / 'lines_strokes.csv')
    (tmp_path / 'profile.csv').write_text(profile_csv(
        printed(test, Ink(1.2e-3, start_lag=0.2, stop_lag=9.0), spacing=2e-4)))
    (tmp_path / 'summary.json').write_text('{}')
    capsys.readouterr()
    run('judge', tmp_path, '--strokes', tmp_path / 'lines_strokes.csv', '--design-at', '0,0,0,0',
        '--json')
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    lines = [event for event in events if event['event'] == 'line']
    assert len(lines) == 4
    for line in lines:
        assert tuple(line)[1:] == sweep_table.COLUMNS
        assert line['width_mm'] == pytest.approx(1.2)
        assert line['start_lag_s'] == pytest.approx(0.2, abs=0.04)
        assert line['stop_lag_s'] is None
    notes = {event['note'] for event in events if event.get('quantity') == 'stop_lag'}
    assert notes == {'ink is seen to the end of the way behind it'}


def test_a_stroke_that_is_not_there_is_warned_of(tmp_path: Path,
                                                 capsys: pytest.CaptureFixture[str]) -> None:
    run('turns', '--out', tmp_path, *FOR)
    test = read_test_print(tmp_path / 'turns_strokes.csv')
    (tmp_path / 'profile.csv').write_text(profile_csv(
        printed(test, Ink(1e-3), left_out=(2,), spacing=2e-4)))
    (tmp_path / 'summary.json').write_text('{}')
    run('judge', tmp_path, '--strokes', tmp_path / 'turns_strokes.csv', '--design-at', '0,0,0,0')
    assert 'strokes 3: expected in the print, found none' in capsys.readouterr().err


@pytest.mark.parametrize(('words', 'message'), [
    (('--nozzle-mm', 1, '--bed-mm', '20,20'), 'take a larger bed'),
    ((*FOR, '--speeds-mm-s', 'fast'), 'expected numbers as 1,2.5,4, found'),
    ((*FOR, '--speeds-mm-s', 'nan'), 'expected numbers as 1,2.5,4, found'),
    (('--nozzle-mm', 1, '--bed-mm', '60'), 'expected its size along x and y as 60,60'),
    (('--nozzle-mm', 410, '--bed-mm', '60,60'), 'is it in millimetres?'),
    ((*FOR, '--plunger-mm', 0), 'inner diameter of the syringe')])
def test_what_is_not_written(words: tuple[object, ...], message: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=message.replace('?', r'\?')) as refused:
        run('lines', '--out', tmp_path / 'new', *words)
    assert '; ' in str(refused.value)
    assert not (tmp_path / 'new').exists()


@pytest.mark.parametrize(('words', 'message'), [
    (('--strokes', 'lines.csv'), 'name the one that'),
    (('--strokes', 'x_strokes.csv'), 'expected a readable stroke table'),
    (('--strokes', 'x_strokes.csv', '--state-hz', 0), 'it is the rate of extrusion_state')])
def test_what_is_not_judged(words: tuple[object, ...], message: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=message):
        run('judge', tmp_path, *words)
