"""Recordings with more than one print, and the folders that results are written into."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest

from bpc_sim.printer.print_recording import record_print
from bpc_sim.printer.scenarios import line
from bpc_system_tests.parts.command_line import refusal, run, succeed

pytestmark = [pytest.mark.system]

CAPTURES = 3  # of each print


@pytest.fixture(scope='module')
def three(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same line three times, each on a new bed."""
    bag = tmp_path_factory.mktemp('several') / 'three'
    job = line(0.025)
    record_print(job, bag, job.duration / CAPTURES, 2e-3, prints=3)
    return bag


def summary(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / 'summary.json').read_text('utf-8'))
    return found


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes()
            for path in sorted(folder.rglob('*')) if path.is_file()}


def test_every_capture_of_every_print_is_there(three: Path, tmp_path: Path) -> None:
    out = tmp_path / 'out'
    succeed('measure', three, '--out', out, '--all', '--quiet')
    overview = summary(out)
    assert [each['print'] for each in overview['prints']] == [1, 2, 3]
    assert len({each['print_id'] for each in overview['prints']}) == 3
    for number, each in enumerate(overview['prints'], 1):
        folder = out / f'print_{number}'
        assert each['folder'] == folder.name
        assert sorted(path.name for path in folder.iterdir()) == [
            *(f'capture_{capture:04d}' for capture in range(CAPTURES)),
            'profile.csv', 'report.html', 'summary.json']
        for capture in range(CAPTURES):
            found = summary(folder / f'capture_{capture:04d}')
            assert (found['print_id'], found['capture']) == (each['print_id'], capture)
        assert summary(folder)['captures'][-1]['capture'] == CAPTURES - 1
    page = (out / 'report.html').read_text('utf-8')
    assert all(f'print_{number}/report.html' in page for number in (1, 2, 3))


def test_one_print_can_be_asked_for(three: Path, tmp_path: Path) -> None:
    succeed('measure', three, '--out', tmp_path / 'all', '--quiet')
    succeed('measure', three, '--out', tmp_path / 'second', '--print', 2, '--quiet')
    assert (tmp_path / 'second' / 'profile.csv').read_bytes() == (
        tmp_path / 'all' / 'print_2' / 'profile.csv').read_bytes()
    assert 'prints' not in summary(tmp_path / 'second')
    said = refusal('measure', three, '--out', tmp_path / 'fourth', '--print', 4, '--quiet')
    assert 'expected print 4, found 3' in said
    assert not (tmp_path / 'fourth').exists()


def test_an_earlier_result_is_replaced_as_a_whole(three: Path, tmp_path: Path) -> None:
    out = tmp_path / 'out'
    succeed('measure', three, '--out', out, '--all', '--quiet')
    (out / 'notes.txt').write_text('of mine')
    succeed('measure', three, '--out', out, '--print', 1, '--quiet')
    assert sorted(files(out)) == ['notes.txt', 'profile.csv', 'report.html', 'summary.json']
    assert (out / 'notes.txt').read_text() == 'of mine'


def test_nothing_is_written_over_what_is_not_ours(three: Path, tmp_path: Path) -> None:
    out = tmp_path / 'thesis'
    out.mkdir()
    (out / 'profile.csv').write_text('chapter,page')
    before = files(tmp_path)
    said = refusal('measure', three, '--out', out)
    assert 'expected a new folder, an empty one, or an earlier result of bpc' in said
    assert files(tmp_path) == before


def test_a_measurement_that_fails_leaves_the_earlier_result(three: Path, tmp_path: Path) -> None:
    out = tmp_path / 'out'
    succeed('measure', three, '--out', out, '--quiet')
    before = files(tmp_path)
    refusal('measure', three, '--out', out, '--capture', 7, '--quiet')  # no print has as many
    assert files(tmp_path) == before


def test_a_batch_has_a_row_for_each_print(three: Path, tmp_path: Path) -> None:
    out = tmp_path / 'table'
    for _ in range(2):  # the second time nothing is measured again
        ended = run('batch', three.parent, '--out', out, '--workers', 1)
        assert ended.returncode == 0, ended.stderr
        with (out / 'prints.csv').open(encoding='utf-8', newline='') as stream:
            rows = list(csv.DictReader(stream))
        assert [row['print'] for row in rows] == ['1', '2', '3']
        assert len({row['print_id'] for row in rows}) == 3
        assert [Path(row['results']).name for row in rows] == ['print_1', 'print_2', 'print_3']
    assert 'measured before' in ended.stdout
