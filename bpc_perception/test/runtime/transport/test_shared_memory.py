"""Shared memory of killed processes is removed, that of living processes never."""

from __future__ import annotations

import fcntl
import mmap
import os
from pathlib import Path

import pytest

from bpc_perception.runtime.transport.shared_memory import clean, unused, used_by

SEGMENT, PORT = 'fastrtps_0123456789abcdef', 'fastrtps_port7411'


def segment(folder: Path, name: str = SEGMENT, lock: str = '_el') -> list[Path]:
    """Make the files of a segment or port that no process uses."""
    files = [folder / name, folder / f'{name}{lock}', folder / f'sem.{name}_mutex']
    files[0].write_bytes(bytes(mmap.PAGESIZE))
    for file in files[1:]:
        file.touch()
    return files


@pytest.mark.parametrize('lock', ['_el', '_sl'])
@pytest.mark.parametrize('name', [SEGMENT, PORT])
def test_what_nobody_uses_is_removed(tmp_path: Path, name: str, lock: str) -> None:
    segment(tmp_path, name, lock)
    others = [tmp_path / other for other in (
        'sem.something', 'fastrtps_short', 'fastrtps_port123456', 'something_el')]
    for other in others:
        other.touch()
    assert clean(tmp_path, settled=0) == mmap.PAGESIZE
    assert sorted(tmp_path.iterdir()) == sorted(others)


def test_what_is_locked_stays(tmp_path: Path) -> None:
    files = segment(tmp_path)
    with files[1].open() as owner:
        fcntl.flock(owner, fcntl.LOCK_SH)
        assert clean(tmp_path, settled=0) == 0
        assert sorted(tmp_path.iterdir()) == sorted(files)
    assert clean(tmp_path, settled=0) == mmap.PAGESIZE


def test_what_is_mapped_stays(tmp_path: Path) -> None:
    files = segment(tmp_path, PORT)
    with files[0].open('r+b') as stream, mmap.mmap(stream.fileno(), 0):
        assert clean(tmp_path, settled=0) == 0
        assert all(file.exists() for file in files)
    assert clean(tmp_path, settled=0) == mmap.PAGESIZE


def test_who_leaves_removes_what_it_alone_has_mapped_of_others(tmp_path: Path) -> None:
    others, mine = segment(tmp_path), segment(tmp_path, PORT)
    with (others[0].open('r+b') as stream, mmap.mmap(stream.fileno(), 0),
          mine[1].open() as owner):
        fcntl.flock(owner, fcntl.LOCK_SH)
        assert clean(tmp_path, settled=0) == 0
        assert clean(tmp_path, settled=0, leaving=True) == mmap.PAGESIZE
    assert sorted(tmp_path.iterdir()) == sorted(mine)


def test_only_what_a_process_used_is_removed_after_it(tmp_path: Path) -> None:
    mine, others = segment(tmp_path), segment(tmp_path, PORT)
    with mine[0].open('r+b') as stream, mmap.mmap(stream.fileno(), 0):
        assert SEGMENT in used_by(os.getpid())  # beside those of tests before this one
        assert PORT not in used_by(os.getpid())
    assert clean(tmp_path, settled=0, among={SEGMENT}) == mmap.PAGESIZE
    assert sorted(tmp_path.iterdir()) == sorted(others)
    assert used_by(2**22 + 1) == set()  # beyond the largest process id


def test_a_profile_stays_as_long_as_its_process_reads_it(tmp_path: Path) -> None:
    file = tmp_path / 'bpc_0a_b1c2d.xml'
    with file.open('w') as owner:
        fcntl.flock(owner, fcntl.LOCK_EX)
        assert file.name in used_by(os.getpid())
        clean(tmp_path, settled=0)
        assert file.exists()
    assert file.name not in used_by(os.getpid())
    clean(tmp_path, settled=0)
    assert not file.exists()


def test_nobody_takes_a_port_while_it_is_removed(tmp_path: Path) -> None:
    files = segment(tmp_path, PORT)
    found = []
    for file in unused(tmp_path, settled=0):
        found.append(file)
        with files[1].open('rb') as other, pytest.raises(BlockingIOError):
            fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)
    assert sorted(found) == sorted(files)


def test_what_is_young_stays(tmp_path: Path) -> None:
    """Its process may not have locked it yet."""
    files = segment(tmp_path)
    assert clean(tmp_path, settled=1000) == 0
    for file in files:
        os.utime(file, (0, 0))
    assert clean(tmp_path, settled=1000) == mmap.PAGESIZE


def test_a_folder_that_is_not_there_needs_no_cleaning(tmp_path: Path) -> None:
    assert clean(tmp_path / 'none') == 0
