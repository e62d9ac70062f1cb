"""The running print on disk is the one that was published, whatever happened afterwards."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
import os
from pathlib import Path
import resource
import subprocess
import sys

import numpy as np
from perception_builders import path_through, SECOND, START_NS
import pytest

from bpc_perception.core.config import PathConfig, PoseConfig, RecorderConfig
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.growing_path import GrowingPath

pytest.importorskip('rclpy')
from bpc_perception.recording import path_journal
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.path_journal import (
    default_folder,
    OtherSettingsError,
    PathJournal,
    TOPIC,
)

pytestmark = pytest.mark.ros
FILE = 'running_print.mcap'
CONFIG = RecorderConfig()
COUNT = 40


def whole(count: int = COUNT) -> DepositionPath:
    x = 1e-3 * np.arange(count)
    return path_through(np.column_stack((x, x**2, 0 * x)), finished=False)


def grow(path: GrowingPath, target: DepositionPath, count: int, finished: bool = False) -> None:
    """Let a path grow to the first points of a target."""
    part = target.where(np.arange(len(target)) < count)
    path.extend(0, replace(part, complete_until=float(part.time[-1]), finished=finished))


@contextmanager
def journal_in(folder: Path) -> Iterator[PathJournal]:
    journal = PathJournal(folder, CONFIG)
    try:
        yield journal
    finally:
        journal.close()


def keep(journal: PathJournal, path: GrowingPath, first: int, count: int,
         finished: bool = False) -> None:
    """Keep a path while it grows by a point each second."""
    for number in range(first, count + 1):
        grow(path, whole(), number, finished and number == count)
        journal.take(path, START_NS + number * SECOND)


def kept(folder: Path, count: int = COUNT, finished: bool = False) -> DepositionPath:
    """Keep a path point by point; return it."""
    path = GrowingPath('print', START_NS)
    with journal_in(folder) as journal:
        keep(journal, path, 1, count, finished)
    return path.path()


def resumed(folder: Path, later: float = 1.0, count: int = COUNT,
            within: float = 30.0) -> DepositionPath | None:
    path = PathJournal(folder, CONFIG).resume(
        START_NS + round((count + later) * SECOND), within)
    return None if path is None else path.path()


def assert_same(one: DepositionPath | None, other: DepositionPath) -> None:
    assert one is not None
    for name in ('print_id', 'start_ns', 'complete_until', 'finished', 'time', 'arc_length',
                 'points', 'plunger_velocity', 'flow_rate', 'extruding', 'extruder_known'):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize('records', [3, 1000])  # the file is begun anew many times, or never
def test_what_was_kept_is_resumed(tmp_path: Path, records: int,
                                  monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(path_journal, 'MOST_RECORDS', records)
    known = kept(tmp_path)
    assert_same(resumed(tmp_path), known)
    assert [file.name for file in tmp_path.iterdir()] == [FILE]


def test_a_resumed_print_is_kept_on(tmp_path: Path) -> None:
    kept(tmp_path, 20)
    with journal_in(tmp_path) as journal:
        path = journal.resume(START_NS + 21 * SECOND, 30.0)
        assert path is not None
        keep(journal, path, 21, COUNT)
    assert_same(resumed(tmp_path), path.path())


def test_what_is_forgotten_of_a_long_print_stays_so(tmp_path: Path,
                                                    monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(GrowingPath, 'MAXIMUM_POINTS', 16)
    monkeypatch.setattr(path_journal, 'MOST_RECORDS', 5)
    known = kept(tmp_path)
    path = PathJournal(tmp_path, CONFIG).resume(START_NS + 41 * SECOND, 30.0)
    assert path is not None
    assert len(path) == COUNT
    np.testing.assert_array_equal(path.path().points[-8:], known.points[-8:])


@pytest.mark.parametrize(('later', 'found'), [
    (0.0, True), (29.9, True), (30.1, False),  # too long ago
    (-0.1, False)])  # the clock has jumped back
def test_a_stale_print_is_not_resumed(tmp_path: Path, later: float, found: bool) -> None:
    kept(tmp_path)
    assert (resumed(tmp_path, later) is not None) == found


def test_an_ended_print_is_not_resumed(tmp_path: Path) -> None:
    kept(tmp_path, finished=True)
    assert resumed(tmp_path) is None


@pytest.mark.parametrize(('changed', 'named'), [
    (replace(CONFIG, nozzle_offset=(0.0, 0.0, 0.1)),
     r'nozzle_offset \(0.0, 0.0, 0.0\) instead of \(0.0, 0.0, 0.1\)'),
    (replace(CONFIG, base_frame='table'), 'base_frame lbr_link_0 instead of table'),
    (replace(CONFIG, pose=PoseConfig(source='tf')), 'pose.source pose_stamped instead of tf'),
    (replace(CONFIG, path=PathConfig(spacing=1e-3, smoothing_time=0)),
     'path.spacing 0.0002 instead of 0.001, path.smoothing_time 0.1 instead of 0.0')])
def test_a_print_left_off_under_other_settings_is_not_resumed(
        tmp_path: Path, changed: RecorderConfig, named: str) -> None:
    known = kept(tmp_path)
    now_ns = START_NS + (COUNT + 1) * SECOND
    with pytest.raises(OtherSettingsError, match=f'found {named}$'):
        PathJournal(tmp_path, changed).resume(now_ns, 30.0)
    # A print that is too old is silently left out.
    assert PathJournal(tmp_path, changed).resume(now_ns + 30 * SECOND, 30.0) is None
    # Settings may change on which the points do not depend.
    path = PathJournal(tmp_path, replace(CONFIG, publish_rate=10.0)).resume(now_ns, 30.0)
    assert path is not None
    assert_same(path.path(), known)


def test_a_print_left_off_under_unknown_settings_is_not_resumed(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('mcap.writer.Writer.add_metadata', lambda *_: None)
    kept(tmp_path)
    with pytest.raises(OtherSettingsError, match='found base_frame unknown instead of lbr_link_0'):
        resumed(tmp_path)


def test_of_two_prints_the_newer_is_resumed(tmp_path: Path) -> None:
    second = GrowingPath('second', START_NS)
    grow(second, replace(whole(), print_id='second'), 3)
    with journal_in(tmp_path) as journal:
        keep(journal, GrowingPath('print', START_NS), 1, COUNT)
        journal.take(second, START_NS + 50 * SECOND)
    assert_same(resumed(tmp_path, count=50), second.path())


def test_a_user_without_a_home_is_told_to_set_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown() -> Path:
        raise RuntimeError('Could not determine home directory.')

    monkeypatch.delenv('XDG_STATE_HOME', raising=False)
    monkeypatch.setattr(Path, 'home', unknown)
    with pytest.raises(ValueError, match='HOME: expected the folder of the user, found none'):
        default_folder()


def test_every_namespace_of_a_domain_has_a_folder_of_its_own(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('XDG_STATE_HOME', str(tmp_path))
    monkeypatch.setenv('ROS_DOMAIN_ID', '7')
    assert default_folder() == tmp_path / 'bpc' / 'domain_7'
    assert default_folder('/cell/a') == tmp_path / 'bpc' / 'domain_7' / 'cell' / 'a'


def test_without_a_print_there_is_none(tmp_path: Path) -> None:
    assert resumed(tmp_path / 'new') is None
    kept(tmp_path)
    PathJournal(tmp_path, CONFIG).remove()
    assert resumed(tmp_path) is None


def test_a_print_that_stands_still_is_not_written_all_the_time(tmp_path: Path) -> None:
    path = GrowingPath('print', START_NS)
    grow(path, whole(), 10)
    with journal_in(tmp_path) as journal:
        for number in range(1000):
            journal.take(path, START_NS + number * SECOND // 100)
    assert len(list(Bag(tmp_path / FILE).messages({TOPIC}))) == 20


def test_the_end_of_a_print_is_written_once(tmp_path: Path) -> None:
    path = GrowingPath('print', START_NS)
    with journal_in(tmp_path) as journal:
        keep(journal, path, 1, 10, finished=True)
        for number in range(100):
            journal.take(path, START_NS + (10 + number) * SECOND)
    assert len(list(Bag(tmp_path / FILE).messages({TOPIC}))) == 10


def test_torn_anywhere_it_holds_what_came_before(tmp_path: Path) -> None:
    known = kept(tmp_path)
    content = (tmp_path / FILE).read_bytes()
    lengths = []
    for size in range(0, len(content), 997):
        (tmp_path / FILE).write_bytes(content[:size])
        path = resumed(tmp_path)
        if path is not None:
            np.testing.assert_array_equal(path.points, known.points[:len(path)])
        lengths.append(0 if path is None else len(path))
    assert lengths == sorted(lengths)
    assert 0 < lengths[len(lengths) // 2] < COUNT


@pytest.mark.parametrize('content', [b'', b'no journal', bytes(10000)])
def test_a_file_that_is_no_journal_is_none(tmp_path: Path, content: bytes) -> None:
    (tmp_path / FILE).write_bytes(content)
    assert resumed(tmp_path) is None
    known = kept(tmp_path)
    assert_same(resumed(tmp_path), known)


KILLED = """
import os, sys
sys.path[:0] = sys.argv[2:]
from pathlib import Path
from test_path_journal import kept
kept(Path(sys.argv[1]))
os.kill(os.getpid(), 9)
"""


def test_a_killed_process_leaves_all_that_it_kept(tmp_path: Path) -> None:
    subprocess.run([sys.executable, '-c', KILLED, str(tmp_path), str(Path(__file__).parents[1]),
                    str(Path(__file__).parent)],
                   check=False, timeout=60)
    path = resumed(tmp_path)
    assert path is not None
    assert len(path) == COUNT


def test_on_a_full_disk_nothing_is_kept_and_that_is_said_once(tmp_path: Path) -> None:
    """A limit on the size of a file stands in for a full disk: both fail in write()."""
    path, other = GrowingPath('print', START_NS), GrowingPath('other', START_NS)
    grow(other, replace(whole(), print_id='other'), 3)
    with journal_in(tmp_path) as journal:
        keep(journal, path, 1, 1)
        with files_limited_to((tmp_path / FILE).stat().st_size + 100):
            with pytest.raises(OSError, match='File too large'):
                keep(journal, path, 2, 2)
            keep(journal, path, 3, 3)
        assert list(tmp_path.iterdir()) == []
        journal.take(other, START_NS + 3 * SECOND)  # there is room again
    assert_same(resumed(tmp_path, count=3), other.path())


@contextmanager
def files_limited_to(size: int) -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_full_disk_at_the_start_leaves_no_half_file(tmp_path: Path) -> None:
    os.symlink('/dev/full', tmp_path / 'running_print.tmp')
    with journal_in(tmp_path) as journal, pytest.raises(OSError, match='No space left'):
        keep(journal, GrowingPath('print', START_NS), 1, 1)
    assert not (tmp_path / FILE).exists()
