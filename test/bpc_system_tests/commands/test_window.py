"""`bpc window` as a user runs it: on tables by hand, and its settings in the next measurement."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import pytest

from bpc_perception.files.sweep_table import COLUMNS
from bpc_system_tests.parts.command_line import refusal, run, SAMPLE, succeed
from bpc_system_tests.parts.ros_graph import own_domain

pytestmark = [pytest.mark.system]
TARGET_MM = 0.7
SPREADING = 1.5
FLOW_PER_SPEED = math.pi / 8 * TARGET_MM**2  # mm², of a bead that is half a circle
FLOWS, SPEEDS = (1.0, 1.5, 2.2, 3.3), (5.0, 8.0, 12.0, 18.0)


def write_sweep(folder: Path, by: str = 'flow_mm3_s', separator: str = ',') -> Path:
    """Write a sweep of beads that are half a circle; the thinnest broke up."""
    rows = []
    for number, (flow, speed) in enumerate(((a, b) for a in FLOWS for b in SPEEDS), 1):
        row = dict.fromkeys(COLUMNS, '')
        row |= {'line': number, by: flow * (1 if by == 'flow_mm3_s' else 40), 'speed_mm_s': speed}
        if speed / flow < 17:
            # Half a percent to and fro, as no measurement is without.
            width = math.sqrt(8 / math.pi * flow / speed) * (1 + 0.005 * (-1)**(number * 7 // 3))
            row |= {'width_mm': f'{width:.4f}', 'width_sigma_mm': 0.005,
                    'area_mm2': f'{flow / speed:.5f}', 'area_sigma_mm2': 0.01}
        rows.append(row)
    folder.mkdir(parents=True, exist_ok=True)
    text = [separator.join(COLUMNS)] + [
        separator.join(str(value).replace('.', ',') if separator == ';' else str(value)
                       for value in row.values()) for row in rows]
    (folder / 'sweep.csv').write_text('\n'.join(text), encoding='utf-8-sig')
    return folder


def test_the_recommended_setting_is_right_by_geometry(tmp_path: Path) -> None:
    sweep, out = write_sweep(tmp_path / 'sweep'), tmp_path / 'out'
    text = succeed('window', sweep, '--target-mm', TARGET_MM, '--tolerance', 0.1, '--out', out,
                   '--figures')
    for word in ('16 lines, 1 without a width: line 4', 'width = ', 'from line to line',
                 'recommended: ', 'next_print.yaml'):
        assert word in text
    assert {file.name for file in out.iterdir()} == {
        'window.csv', 'window.json', 'window.html', 'next_print.yaml', 'window.pdf', 'window.svg'}
    found = json.loads((out / 'window.json').read_text())['settings']
    width = math.sqrt(8 / math.pi * found['flow_mm3_s'] / found['speed_mm_s'])
    assert width == pytest.approx(TARGET_MM, rel=0.01)
    with (out / 'window.csv').open(newline='') as stream:
        assert any(row['flow_mm3_s'] for row in csv.DictReader(stream))


@pytest.mark.ros
def test_its_settings_file_is_that_of_the_next_measurement(tmp_path: Path) -> None:
    out, measured = tmp_path / 'out', tmp_path / 'measured'
    succeed('window', write_sweep(tmp_path / 'sweep'), '--target-mm', TARGET_MM, '--tolerance',
            0.2, '--out', out, '--params', SAMPLE / 'params.yaml', '--quiet')
    succeed('measure', SAMPLE, '--params', out / 'next_print.yaml', '--out', measured, '--quiet')
    settings = json.loads((measured / 'summary.json').read_text())['settings']
    assert settings['advice.target_thickness'] == pytest.approx(TARGET_MM * 1e-3)
    assert settings['tolerance.width'] == 0.2
    # Nobody publishes anything here, so that all but the settings fails.
    with own_domain():
        said = run('check', '--handeye', SAMPLE / 'hand_eye.calib', '--params',
                   out / 'next_print.yaml', '--seconds', 0.5).stdout
    assert f'OK   target thickness: {TARGET_MM:g} mm' in said
    assert 'OK   nozzle offset' in said


def test_pressure_semicolons_and_several_sweeps(tmp_path: Path) -> None:
    sweeps = [write_sweep(tmp_path / name, 'pressure_kpa', ';') for name in ('one', 'two')]
    lines = [json.loads(line) for line in succeed(
        'window', *sweeps, '--target-mm', TARGET_MM, '--speed-mm-s', 10, '--json').splitlines()]
    (settings,) = (line for line in lines if line['event'] == 'settings')
    assert settings['speed_mm_s'] == 10
    assert settings['pressure_kpa'] == pytest.approx(40 * 10 * FLOW_PER_SPEED, rel=0.02)
    assert settings['expected_width_mm'] == pytest.approx(TARGET_MM, rel=0.01)
    assert sum(line['event'] == 'speed' for line in lines) > 10


def test_refusals(tmp_path: Path) -> None:
    sweep = write_sweep(tmp_path / 'sweep')
    wanted = ('--target-mm', TARGET_MM)
    assert 'is it in millimetres?' in refusal('window', sweep, '--target-mm', 700)
    assert 'write 0.1 for 10 %' in refusal('window', sweep, *wanted, '--tolerance', 10)
    assert 'name one with --out' in refusal('window', sweep, *wanted, '--figures')
    assert 'name one with --out' in refusal('window', sweep, *wanted, '--params', sweep)
    assert 'expected each sweep once' in refusal('window', sweep, sweep, *wanted)
    assert 'as the sweep has it, found 2.000 mm; nearest is line 13' in refusal(
        'window', sweep, '--target-mm', 2)
    assert 'found: No such file or directory' in refusal('window', tmp_path / 'no', *wanted)
    (tmp_path / 'window.csv').write_text('mine')
    assert 'found window.csv; name another folder with --out' in refusal(
        'window', sweep, *wanted, '--out', tmp_path)
    assert (tmp_path / 'window.csv').read_text() == 'mine'
    assert run('window', sweep).returncode == 2


def test_from_a_test_print_to_the_setting_of_its_ink(tmp_path: Path) -> None:
    """The bead of the simulated ink is SPREADING times as wide as a round strand."""
    there, target_mm = tmp_path / 'print', 1.4
    succeed('testprint', 'lines', '--out', there, '--nozzle-mm', 1, '--bed-mm', '150,150',
            '--flows-mm3-s', '4,5.5,7.5', '--speeds-mm-s', '6,9,13', '--quiet')
    succeed('sim', '--design', there / 'lines.csv', '--record', there / 'bag', '--rate', 0.03,
            '--spreading', SPREADING, '--dead-time', 0.2, '--lag', 0.001, '--quiet')
    succeed('testprint', 'judge', there / 'bag', '--strokes', there / 'lines_strokes.csv',
            '--out', there / 'judged', '--quiet')
    succeed('window', there / 'judged', '--target-mm', target_mm, '--out', there / 'window',
            '--quiet')
    found = json.loads((there / 'window' / 'window.json').read_text())['settings']
    width = SPREADING * math.sqrt(4 / math.pi * found['flow_mm3_s'] / found['speed_mm_s'])
    assert width == pytest.approx(target_mm, rel=0.03)
    assert found['start_lag_s'] == pytest.approx(0.2, abs=0.06)
    assert found['delivered_share'] == pytest.approx(1, abs=0.1)
