"""A recording for each print, with what came shortly before it."""

from __future__ import annotations

from pathlib import Path

import pytest

from bpc_perception.core.path.print_id import print_id_of, start_of
from bpc_perception.recording.inputs import PRINT_ID
from bpc_perception.recording.print_bags import AFTER_NS, HISTORY_NS, PrintBags
from bpc_perception.recording.print_folder import free_recording, print_folder
from bpc_perception.recording.storage import mcap_file

SECOND = 10**9
TYPES = {'/pose': 'std_msgs/msg/String', '/image': 'std_msgs/msg/String',
         '/profile': 'std_msgs/msg/String'}
FIRST, SECOND_PRINT = '20260711T100000.000Z', '20260711T101500.250Z'


def bags(prints: Path) -> PrintBags:
    return PrintBags(prints, TYPES, ['/pose'], ['/image'], {'params.yaml': b'{}'})


def recorded(folder: Path) -> list[tuple[str, float, bytes]]:
    """Topic, time [s] and content of all messages of the recording in a folder."""
    file, = folder.glob('*.mcap')
    return [(message.topic, message.log_ns / SECOND, message.data)
            for message in mcap_file.messages(file)]


def test_a_print_is_recorded_with_what_came_before_it(tmp_path: Path) -> None:
    bag = bags(tmp_path)
    for second in range(1, 31):
        bag.write('/pose', second * SECOND, b'%d' % second)
    bag.write('/image', 28 * SECOND, b'old')
    bag.write('/image', 29 * SECOND, b'bed')
    bag.write('/profile', 30 * SECOND, b'of another print')
    assert not list(tmp_path.iterdir())
    bag.follow(FIRST, finished=False, log_ns=30 * SECOND)
    bag.write('/pose', 31 * SECOND, b'31')
    bag.write('/profile', 31 * SECOND, b'own')
    bag.close()
    folder = print_folder(tmp_path, FIRST) / 'recording'
    found = recorded(folder)
    first = 30 - HISTORY_NS // SECOND
    assert [time for topic, time, _ in found if topic == '/pose'] == list(range(first, 32))
    assert [data for topic, _, data in found if topic == '/image'] == [b'bed']
    assert [data for topic, _, data in found if topic == '/profile'] == [b'own']
    assert [time for _, time, _ in found] == sorted(time for _, time, _ in found)
    assert (folder / 'params.yaml').read_bytes() == b'{}'
    assert (folder / PRINT_ID).read_text() == FIRST
    assert (folder / 'metadata.yaml').exists()


def test_the_next_print_has_a_recording_of_its_own(tmp_path: Path) -> None:
    """What came just before its start is in both."""
    bag = bags(tmp_path)
    bag.follow(FIRST, finished=False, log_ns=0)
    for second in (1, 2, 3):
        bag.write('/pose', second * SECOND, b'')
    bag.follow(SECOND_PRINT, finished=False, log_ns=3 * SECOND)
    bag.write('/pose', 4 * SECOND, b'')
    bag.close()
    times = [[time for _, time, _ in recorded(print_folder(tmp_path, name) / 'recording')]
             for name in (FIRST, SECOND_PRINT)]
    assert times == [[1, 2, 3], [1, 2, 3, 4]]


def test_after_its_end_a_print_is_recorded_for_a_while_and_again_when_it_goes_on(
        tmp_path: Path) -> None:
    bag, after = bags(tmp_path), AFTER_NS // SECOND
    bag.follow(FIRST, finished=False, log_ns=0)
    bag.write('/pose', SECOND, b'')
    bag.follow(FIRST, finished=True, log_ns=SECOND)
    bag.follow(FIRST, finished=True, log_ns=30 * SECOND)  # said again
    for second in (after, after + 10, after + 100, after + 105):
        bag.write('/pose', second * SECOND, b'')
    bag.write('/image', (after + 106) * SECOND, b'')
    bag.follow(FIRST, finished=False, log_ns=(after + 107) * SECOND)
    bag.write('/profile', (after + 108) * SECOND, b'')
    bag.close()
    assert [time for _, time, _ in recorded(print_folder(tmp_path, FIRST) / 'recording')] == [
        1, after, *(after + later for later in (100, 105, 106, 108))]


def test_a_recorder_that_was_killed_leaves_its_recording_and_begins_another(
        tmp_path: Path) -> None:
    recorders = [bags(tmp_path), bags(tmp_path)]
    for bag, data in zip(recorders, (b'before', b'after'), strict=True):
        bag.follow(FIRST, finished=False, log_ns=0)
        bag.write('/pose', SECOND, data)
        bag.flush()
    folder = print_folder(tmp_path, FIRST)
    assert [recorded(folder / name) for name in ('recording', 'recording_2')] == [
        [('/pose', 1, b'before')], [('/pose', 1, b'after')]]
    assert free_recording(folder).name == 'recording_3'
    for bag in recorders:
        bag.close()


def test_a_folder_is_named_by_the_local_time_of_the_start(
        tmp_path: Path) -> None:
    start_ns = 1_783_764_000_250_000_000  # 2026-07-11 10:00:00.25 UTC
    assert print_id_of(start_ns) == '20260711T100000.250Z'
    start = start_of(print_id_of(start_ns))
    assert start is not None
    assert round(start.timestamp() * 1000) == start_ns // 10**6
    name = print_folder(tmp_path, print_id_of(start_ns)).name
    assert name == f'{start.astimezone():%Y-%m-%d_%H-%M-%S}.250'


@pytest.mark.parametrize('print_id', ['../../etc', 'a/b', '.hidden', 'day 3 #1', '..'])
def test_a_foreign_identifier_leads_out_of_no_folder(tmp_path: Path, print_id: str) -> None:
    folder = print_folder(tmp_path, print_id)
    assert folder.parent == tmp_path
    assert not folder.name.startswith('.')
