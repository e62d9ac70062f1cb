"""Recordings survive their recorder, and other programs read them."""

from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path
import secrets
import subprocess

from mcap.reader import make_reader, NonSeekingReader
import numpy as np
import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores
from std_msgs.msg import String

from bpc_perception.messages import topics
from bpc_perception.recording.atomic import atomic_bag, inside
from bpc_perception.recording.bag import Bag, BagError
from bpc_perception.recording.bag_writer import BagWriter
from bpc_perception.recording.storage.storage import open_storage
from bpc_perception.runtime.transport.shared_memory import SHARED_MEMORY
from bpc_system_tests.parts.command_line import run, running, SAMPLE, succeed
from bpc_system_tests.parts.ros_graph import own_domain
from bpc_system_tests.parts.text_bags import STRING, texts, words
from bpc_system_tests.robustness.killed_recorder import (
    counts,
    kill_recorders,
    KILL_TIMES_S,
    MAX_POSES_LOST_S,
    read_by_javascript,
    READER,
    Remains,
)

# .ci/run installs the reader and sets this variable, so that the tests are never skipped there.
javascript = pytest.mark.skipif(
    not (READER / 'node_modules').exists() and 'BPC_ALL_READERS' not in os.environ,
    reason='needs Node.js and `npm ci --prefix test/mcap_reader`')


def by_mcap(file: Path) -> dict[str, int]:
    """Count the messages of each topic with the mcap package, from front to back."""
    found: dict[str, int] = {}
    with file.open('rb') as stream:
        try:
            for _, channel, _ in NonSeekingReader(stream).iter_messages(log_time_order=False):
                found[channel.topic] = found.get(channel.topic, 0) + 1
        except Exception:  # whatever it raises at the torn end
            return found
    return found


def by_rosbags(folder: Path) -> dict[str, int]:
    """Count the messages of each topic with rosbags."""
    found: dict[str, int] = {}
    with Reader(folder) as reader:
        for connection, _, _ in reader.messages():
            found[connection.topic] = found.get(connection.topic, 0) + 1
    return found


@pytest.fixture(scope='module')
def torn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bag of ten messages whose recorder was stopped in the middle of the eleventh."""
    folder = tmp_path_factory.mktemp('torn')
    writer = BagWriter(folder / 'torn')
    writer.add_topic('/words', STRING)
    for number, word in enumerate(words(10)):
        writer.write('/words', number, word)
        writer.flush()
    file, = Bag(writer.path).files
    whole = file.stat().st_size
    writer.write('/words', 10, String(data='x' * 100_000))
    writer.close()
    (writer.path / 'metadata.yaml').unlink()
    os.truncate(file, whole + 50_000)
    (folder / 'torn' / 'params.yaml').write_text('{}')
    (folder / 'torn' / 'print_id.txt').write_text('20260711T122333.088Z\n')
    return folder / 'torn'


@pytest.fixture(scope='module')
def recovered(torn: Path) -> tuple[Path, subprocess.CompletedProcess[str]]:
    """The bag that `bpc recover` makes of it, and the output."""
    target = torn.parent / 'mended'
    return target, run('recover', torn, '--out', target)


# A recorder that is killed


@pytest.fixture(scope='module')
def left(tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[Remains]]:
    """What two recorders leave when they are killed while they record."""
    moments = np.random.default_rng(5).uniform(*KILL_TIMES_S, 2).tolist()
    with own_domain() as domain:
        yield kill_recorders(tmp_path_factory.mktemp('killed'), domain, moments, 304, 228)


def test_a_killed_recorder_leaves_all_but_the_last_half_second(left: list[Remains]) -> None:
    for each in left:
        assert each.poses_lost <= MAX_POSES_LOST_S
        assert each.frames_lost == 0
        assert each.frames > 0


def test_a_recorder_that_starts_removes_what_killed_ones_left(tmp_path: Path) -> None:
    left = SHARED_MEMORY / f'fastrtps_{secrets.token_hex(8)}'
    left.write_bytes(bytes(8))
    os.utime(left, (0, 0))
    try:
        with own_domain(), running('record', '--out', tmp_path / 'bag') as recorder:
            assert recorder.stderr is not None
            assert 'recording into' in recorder.stderr.readline()
            assert not left.exists()
    finally:
        left.unlink(missing_ok=True)


def test_what_a_killed_recorder_leaves_is_the_same_to_every_reader(left: list[Remains]) -> None:
    for each in left:
        file, = Bag(each.bag).files
        assert by_mcap(file) == counts(each.bag)


@javascript
def test_what_a_killed_recorder_leaves_is_the_same_to_javascript(left: list[Remains]) -> None:
    for each in left:
        file, = Bag(each.bag).files
        assert read_by_javascript(file)['stream'] == counts(each.bag)


# A recorder that packs


def test_a_print_recorded_packed_is_measured_as_it_was_published(
        tmp_path: Path, measured_sample: Path) -> None:
    bag, plain = tmp_path / 'packed', tmp_path / 'plain'
    with own_domain(), running('record', '--out', bag, '--compress', '--handeye',
                 SAMPLE / 'hand_eye.calib', '--params', SAMPLE / 'params.yaml') as recorder:
        assert recorder.stderr is not None
        assert 'recording into' in recorder.stderr.readline()
        succeed('replay', SAMPLE, '--rate', 6, '--out', tmp_path / 'replayed')
    camera = {f'/{name}' for name in topics.CAMERA}
    published, recorded = ([(entry.topic, entry.message) for entry in Bag(each).messages(camera)]
                           for each in (SAMPLE, bag))
    assert sorted(recorded, key=repr) == sorted(published, key=repr)
    succeed('recover', bag, '--out', plain)
    for each in (bag, plain):
        out = tmp_path / f'of_{each.name}'
        succeed('measure', each, '--out', out)
        measured = (out / 'profile.csv').read_bytes()
        assert measured == (measured_sample / 'profile.csv').read_bytes()
    sizes = [sum(len(raw.data) for file in Bag(each).files
                 for raw in open_storage(file).messages(camera)) for each in (bag, plain)]
    assert sizes[0] < 0.5 * sizes[1]


# A torn recording, and its recovery


def test_a_torn_recording_is_recovered(
        recovered: tuple[Path, subprocess.CompletedProcess[str]]) -> None:
    mended, ended = recovered
    assert ended.returncode == 0
    assert '/words: 10 messages' in ended.stdout
    assert 'torn, read up to the damage' in ended.stderr
    assert by_rosbags(mended) == {'/words': 10}
    assert texts(mended) == words(10)
    assert {path.name for path in mended.iterdir()} > {'params.yaml', 'print_id.txt'}
    file, = Bag(mended).files
    with file.open('rb') as stream:
        assert make_reader(stream).get_summary() is not None
    assert sorted(path.name for path in mended.parent.iterdir()) == ['mended', 'torn']


@javascript
def test_a_recovered_recording_has_the_index_that_a_torn_one_lacks(
        torn: Path, recovered: tuple[Path, subprocess.CompletedProcess[str]]) -> None:
    (file,), (mended,) = Bag(torn).files, Bag(recovered[0]).files
    assert read_by_javascript(file) == {'stream': {'/words': 10}, 'index': None}
    assert read_by_javascript(mended) == {'stream': {'/words': 10}, 'index': {'/words': 10}}


def test_nothing_is_put_over_another_recording(torn: Path) -> None:
    with pytest.raises(BagError, match='expected a new bag'), atomic_bag(torn):
        pass


def test_a_bag_that_fails_half_way_leaves_nothing(tmp_path: Path) -> None:
    def fail() -> None:
        with atomic_bag(tmp_path / 'bag') as writer:
            writer.add_topic('/words', STRING)
            writer.write('/words', 1, String())
            writer.flush()
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('name', ['', '.', '..', '../x', '/etc/passwd', 'a/b', 'a\0b'])
def test_a_name_that_leads_out_of_its_folder_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match='expected the name of a file in it, found'):
        inside(tmp_path, name)
    assert inside(tmp_path, '20260101T000000.000Z').parent == tmp_path


# Other programs read our recordings, and we read theirs


@javascript
def test_javascript_reads_what_we_wrote(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as writer:
        for topic in ('/a', '/b'):
            writer.add_topic(topic, STRING)
        for number in range(7):
            writer.write('/a' if number < 3 else '/b', number, String(data='x' * number * 20_000))
    file, = Bag(tmp_path / 'bag').files
    assert read_by_javascript(file) == {
        'stream': {'/a': 3, '/b': 4}, 'index': {'/a': 3, '/b': 4}}


@pytest.mark.parametrize('compressed', [False, True])
def test_we_read_what_rosbags_wrote(tmp_path: Path, compressed: bool) -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    text = store.types[STRING]
    writer = Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.MCAP)
    if compressed:
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection('/words', STRING, typestore=store)
        for number, word in enumerate(words(5)):
            writer.write(connection, number,
                         bytes(store.serialize_cdr(text(data=word.data), STRING)))
    assert texts(tmp_path / 'bag') == words(5)
