"""`bpc printability` as a user runs it: on a recording, and on a result."""

from __future__ import annotations

import csv
import json
from pathlib import Path
import shutil
from typing import Any

import pytest

from bpc_sim.printer.print_recording import record_print
from bpc_sim.printer.scenarios import line
from bpc_system_tests.parts.command_line import refusal, ROOT, run, succeed

pytestmark = [pytest.mark.system]

LATTICE = ROOT / 'bags' / 'lattice'
# Strands of 1.3 mm, 4 mm apart.
SIDE_MM = 4 - 1.3
SAG_MM, STRAND_MM = 0.1, 0.39


@pytest.fixture(scope='module')
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp('result') / 'lattice'
    succeed('measure', LATTICE, '--out', out, '--quiet')
    return out


@pytest.fixture(scope='module')
def of_recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp('printability') / 'lattice'
    succeed('printability', LATTICE, '--out', out, '--figures', '--nozzle-mm', '1.2', '--quiet')
    return out


def rows_of(folder: Path) -> list[dict[str, str]]:
    with (folder / 'printability.csv').open(encoding='utf-8', newline='') as stream:
        return list(csv.DictReader(stream))


def of_print(folder: Path) -> dict[str, dict[str, str]]:
    return {row['metric']: row for row in rows_of(folder) if row['of'] == 'print'}


def events(text: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in text.splitlines()]


def test_the_pores_of_the_sample_lattice(of_recording: Path) -> None:
    pores = [row for row in rows_of(of_recording) if row['row'] == 'pore']
    assert len(pores) == 16
    for pore in pores:
        assert float(pore['area_mm2']) == pytest.approx(SIDE_MM**2, rel=0.03)
        assert float(pore['pr']) == pytest.approx(1, abs=0.02)
        assert float(pore['pr_ideal']) == pytest.approx(1, abs=0.002)
        assert float(pore['mesh_printability_percent']) == pytest.approx(100, abs=3)
        assert abs(float(pore['area_mm2']) - SIDE_MM**2) < 3 * float(pore['area_sigma_mm2'])


def test_the_strands_of_the_sample_lattice(of_recording: Path) -> None:
    found = {name: row['value'] and float(row['value'])
             for name, row in of_print(of_recording).items()}
    assert found['width'] == pytest.approx(1.3, abs=0.02)
    assert found['filament_to_nozzle_ratio'] == pytest.approx(1.3 / 1.2, abs=0.02)
    assert found['width_accuracy'] == pytest.approx(100, abs=2)
    assert found['continuity'] == 1
    assert found['stability'] > 0.97
    assert found['uniformity'] == pytest.approx(1, abs=0.003)
    # Between the supports' edges hang the middle two thirds of a parabola.
    hanging = SAG_MM * (1 - (SIDE_MM / 4) ** 2 / 3)
    assert found['collapse_factor'] == pytest.approx(100 * hanging / STRAND_MM, abs=6)
    assert found['turn_fidelity'] == ''


def test_files(of_recording: Path) -> None:
    assert {path.name for path in of_recording.iterdir()} == {
        'printability.csv', 'pores.pdf', 'pores.svg'}


def test_a_result_tells_the_same(result: Path, of_recording: Path, tmp_path: Path) -> None:
    lines = events(succeed('printability', result, '--out', tmp_path, '--nozzle-mm', 1.2,
                           '--json'))
    assert [each['event'] for each in lines].count('pore') == 16
    assert lines[-1] == {'event': 'file', 'path': str(tmp_path / 'printability.csv')}
    assert 'collapse_factor' in {each.get('metric') for each in lines}
    one, two = of_print(of_recording), of_print(tmp_path)
    assert two['collapse_factor']['value'] == ''
    assert 'name the recording' in two['collapse_factor']['note']
    for name in one.keys() - {'collapse_factor'}:
        values = [row[name]['value'] for row in (one, two)]
        assert [value and pytest.approx(float(value), rel=1e-9) for value in values] == [
            value and float(value) for value in reversed(values)]


def test_tables_for_people(result: Path) -> None:
    text = succeed('printability', result)
    for word in ('pore_printability', 'stroke 10', 'ideal Pr', 'the path has no turns'):
        assert word in text


def test_numbers_go_with_the_result(result: Path, tmp_path: Path) -> None:
    folder = tmp_path / 'result'
    shutil.copytree(result, folder)
    succeed('printability', folder, '--out', folder, '--figures', '--quiet')
    assert {path.name for path in folder.iterdir()} == {
        'profile.csv', 'summary.json', 'report.html', 'printability.csv', 'pores.pdf',
        'pores.svg'}
    # A new result is not to stand beside the numbers of the old one.
    succeed('measure', LATTICE, '--out', folder, '--quiet')
    assert {path.name for path in folder.iterdir()} == {
        'profile.csv', 'summary.json', 'report.html'}


def test_one_of_several_prints(tmp_path: Path) -> None:
    bag, measured = tmp_path / 'two', tmp_path / 'measured'
    job = line(0.025)
    record_print(job, bag, job.duration / 2, 2e-3, prints=2)
    succeed('measure', bag, '--out', measured, '--quiet')
    for source in (bag, measured):
        assert refusal('printability', source).endswith(
            f'{source}: expected one print, found 2; choose one with --print')
        assert 'expected print 3, found 2' in refusal('printability', source, '--print', 3)
    ids = {source: {each['print_id'] for each in events(succeed(
        'printability', source, '--print', 2, '--json')) if each['event'] == 'metric'}
        for source in (bag, measured)}
    assert ids[bag] == ids[measured]
    assert len(ids[bag]) == 1


def test_refusals(result: Path, tmp_path: Path) -> None:
    assert 'expected 0.01 to 20 mm, found 0; is it in millimetres?' in refusal(
        'printability', result, '--nozzle-mm', 0)
    assert 'name one with --out' in refusal('printability', result, '--figures')
    (tmp_path / 'pores.pdf').write_text('mine')
    assert 'found pores.pdf; name another folder with --out' in refusal(
        'printability', result, '--out', tmp_path)
    (tmp_path / 'summary.json').write_text('[]')
    assert 'expected a summary as JSON, found a list' in refusal('printability', tmp_path)
    (tmp_path / 'summary.json').write_text('{}')
    assert 'profile.csv' in refusal('printability', tmp_path)
    (tmp_path / 'profile.csv').write_text('nothing\n')
    assert 'expected a profile as bpc writes it' in refusal('printability', tmp_path)
    assert run('printability', tmp_path / 'nowhere').returncode == 2
