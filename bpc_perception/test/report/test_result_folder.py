"""The folder of a result: what may be written into it, and what has to leave it."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from bpc_perception.report.result_folder import check_recording, replacing, SUMMARY


def leave_result(folder: Path, bag: object) -> None:
    """Leave a result of a recording in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / SUMMARY).write_text(json.dumps({'fingerprint': 'abc', 'bag': str(bag)}))


def test_nothing_of_an_earlier_result_stays_beside_a_new_one(tmp_path: Path) -> None:
    for name in ('figures/map.svg', 'capture_0003/profile.csv', 'print_2/report.html',
                 'report.html', 'sweep.csv', 'findings.csv', 'mine/notes.txt'):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    leave_result(tmp_path, 'print')
    with replacing(tmp_path) as new:
        (new / 'profile.csv').touch()
    assert sorted(path.name for path in tmp_path.iterdir()) == ['mine', 'profile.csv']


def test_results_of_recordings_of_equal_names_do_not_replace_each_other(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / 'out'
    leave_result(out, tmp_path / 'monday' / 'print')
    with pytest.raises(ValueError, match=r'expected no results there but those of .*tuesday/print,'
                                         r' found those of .*monday/print; name another folder'):
        check_recording(out, tmp_path / 'tuesday' / 'print')
    (tmp_path / 'monday').mkdir()
    monkeypatch.chdir(tmp_path / 'monday')
    check_recording(out, Path('print'))
    (tmp_path / 'link').symlink_to('monday')
    check_recording(out, tmp_path / 'link' / 'print')


@pytest.mark.parametrize('summary', ['torn', '[]', '{}', '{"bag": ""}', '{"bag": 3}', None])
def test_what_is_not_known_to_be_of_another_recording_may_be_replaced(
        tmp_path: Path, summary: str | None) -> None:
    if summary is not None:
        (tmp_path / SUMMARY).write_text(summary)
    check_recording(tmp_path, tmp_path / os.fsdecode(b'odd-\xff'))


def test_a_table_that_a_person_made_beside_a_result_stays(tmp_path: Path) -> None:
    (tmp_path / 'summary.json').write_text('{"fingerprint": ""}')
    for name in ('profile.csv', 'profile.xlsx', 'profile.mat'):
        (tmp_path / name).write_text('by hand')
    with replacing(tmp_path) as new:
        (new / 'summary.json').write_text('{}')
    assert {file.name for file in tmp_path.iterdir() if file.suffix} == {
        'summary.json', 'profile.xlsx', 'profile.mat'}
