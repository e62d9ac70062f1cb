"""Recordings survive their recorder, and other programs read them."""

from __future__ import annotations

from collections.abc import Iterator
import errno
import os
from pathlib import Path
import secrets
import shutil
import subprocess
from types import SimpleNamespace
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from mcap.reader import make_reader, NonSeekingReader
import numpy as np
import pytest
from rclpy.node import Node
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores
from sensor_msgs.msg import Image
from std_msgs.msg import String

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.messages import topics
from bpc_perception.nodes import bag_recorder
from bpc_perception.nodes.bag_recorder import BagRecorderNode
from bpc_perception.recording.atomic import atomic_bag, inside
from bpc_perception.recording.bag import Bag, BagError
from bpc_perception.recording.bag_writer import BagWriter
from bpc_perception.runtime.exit_status import REFUSED
from bpc_perception.runtime.isolated_graph import Graph
from bpc_perception.runtime.transport.shared_memory import SHARED_MEMORY
from bpc_system_tests.parts.command_line import run, running
from bpc_system_tests.parts.ros_graph import own_domain
from bpc_system_tests.robustness.killed_recorder import (
    counts,
    kill_recorders,
    KILL_TIMES_S,
    MAX_POSES_LOST_S,
    read_by_javascript,
    READER,
    Remains,
)

STRING = 'std_msgs/msg/String'
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


def words(count: int) -> list[String]:
    return [String(data=f'word {number} ' * 500) for number in range(count)]


def texts(bag: Path) -> list[Any]:
    """Return the messages of /words as our reader reads them."""
    return [message for _, _, message in Bag(bag).messages({'/words'})]


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


# A torn recording, and its recovery


def test_a_torn_recording_is_recovered(
        recovered: tuple[Path, subprocess.CompletedProcess[str]]) -> None:
    mended, ended = recovered
    assert ended.returncode == 0
    assert '/words: 10 messages' in ended.stdout
    assert 'torn, read up to the damage' in ended.stderr
    assert by_rosbags(mended) == {'/words': 10}
    assert texts(mended) == words(10)
    assert (mended / 'params.yaml').exists()
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


# A full disk


def fill_disk(bag: BagWriter) -> None:
    """Let the kernel report a full disk to a writer from now on."""
    with open('/dev/full', 'wb') as full:
        os.dup2(full.fileno(), bag._stream.fileno())


def test_a_full_disk_ends_the_file_but_keeps_what_is_there(tmp_path: Path) -> None:
    writer = BagWriter(tmp_path / 'bag')
    writer.add_topic('/words', STRING)
    for number, word in enumerate(words(3)):
        writer.write('/words', number, word)
    writer.flush()
    file, = Bag(writer.path).files
    copy = tmp_path / 'copy.mcap'
    fill_disk(writer)
    with pytest.raises(OSError, match='No space left') as raised:
        writer.write('/words', 3, String(data='x' * 100_000))
    assert raised.value.errno == errno.ENOSPC
    for last in (lambda: writer.write('/words', 4, String()), writer.flush):
        with pytest.raises(OSError, match='expected a file to go on with, found it torn'):
            last()
    writer.close()
    shutil.copy(file, copy)
    assert texts(copy) == words(3)


def test_a_recorder_on_a_full_disk_stays_and_says_so(tmp_path: Path, ros_domain: int) -> None:
    graph = Graph(ros_domain)
    try:
        recorder = graph.make(BagRecorderNode, bag=str(tmp_path / 'bag'))
        peer = graph.make(Node, 'peer')
        said: list[DiagnosticStatus] = []
        peer.create_subscription(DiagnosticArray, '/diagnostics', lambda message: said.extend(
            status for status in message.status if status.name == 'bag_recorder'), 10)
        poses = peer.create_publisher(PoseStamped, topics.POSE, topics.EXTRUSION_QOS)

        def send_until(condition: Any) -> None:
            def holds() -> Any:
                poses.publish(PoseStamped())
                return condition()
            graph.spin_until(holds)

        send_until(lambda: recorder._diagnostics._counts[f'/{topics.POSE}'] > 10)
        recorder._bag.flush()
        kept = counts(tmp_path / 'bag')[f'/{topics.POSE}']
        fill_disk(recorder._bag)
        send_until(lambda: said and said[-1].level != DiagnosticStatus.OK and any(
            value.key == 'refused: not recorded' for value in said[-1].values))
        assert 'No space left on device' in said[-1].message
        assert str(tmp_path / 'bag') in said[-1].message
        assert counts(tmp_path / 'bag')[f'/{topics.POSE}'] == kept > 10
    finally:
        graph.close()
    assert counts(tmp_path / 'bag')[f'/{topics.POSE}'] == kept
    assert not (tmp_path / 'bag' / 'metadata.yaml').exists()


def test_a_recorder_misses_poses_beside_captures(tmp_path: Path, ros_domain: int,
                                                 monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bag_recorder, 'MISSING_INPUT_PATIENCE_S', 0.3)
    graph = Graph(ros_domain)
    try:
        recorder = graph.make(BagRecorderNode, None, {'params.yaml': b'{}'},
                              bag=str(tmp_path / 'bag'))
        peer = graph.make(Node, 'peer')
        images = peer.create_publisher(Image, topics.IMAGE, topics.CAMERA_QOS)
        states = peer.create_publisher(ExtrusionState, topics.EXTRUSION, topics.EXTRUSION_QOS)

        def said() -> str:
            images.publish(Image())
            states.publish(ExtrusionState())
            return recorder._diagnostics._last_warning

        graph.spin_until(said)
        words = said()
    finally:
        graph.close()
    assert words == (
        '/end_effector_pose: expected messages beside the captures, found none; '
        'without them the recording cannot be measured')
    assert (tmp_path / 'bag' / 'params.yaml').read_bytes() == b'{}'


def test_who_looks_on_a_recording_does_not_end_it(tmp_path: Path, ros_domain: int) -> None:
    """As if the terminal is gone, or the free space of the disk is unknown."""
    looks: list[int] = []

    def on_progress(_: dict[str, int], size: int) -> None:
        looks.append(size)
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    graph = Graph(ros_domain)
    try:
        graph.make(BagRecorderNode, on_progress, bag=str(tmp_path / 'bag'))
        graph.spin_until(lambda: len(looks) > 2)
    finally:
        graph.close()
    assert (tmp_path / 'bag' / 'metadata.yaml').exists()


def test_a_recorder_whose_folder_is_moved_writes_on_and_says_so(
        tmp_path: Path, ros_domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bag_recorder, 'PLACE_PERIOD_S', 0.1)
    looks: list[int] = []
    graph = Graph(ros_domain)
    try:
        recorder = graph.make(BagRecorderNode, lambda _, size: looks.append(size),
                              bag=str(tmp_path / 'bag'))
        graph.spin_until(lambda: looks)
        assert not recorder._diagnostics._last_warning
        (tmp_path / 'bag').rename(tmp_path / 'moved')
        seen = len(looks)
        graph.spin_until(lambda: recorder._diagnostics._last_warning and len(looks) > seen + 2)
        assert recorder._diagnostics._last_warning == (
            f'{tmp_path / "bag"}: expected the recording there, found it moved or removed')
        assert not recorder.failure
        recorder._write(f'/{topics.POSE}', serialize_message(PoseStamped()))
    finally:
        graph.close()
    assert recorder.failure == (f'not completed: expected to write {tmp_path / "bag"}, found: '
                                'No such file or directory')
    assert counts(tmp_path / 'moved')[f'/{topics.POSE}'] == 1


def test_a_recording_that_failed_is_no_success(monkeypatch: pytest.MonkeyPatch,
                                               capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(bag_recorder, 'run', lambda make, **_: make())
    made = SimpleNamespace(failure='')
    monkeypatch.setattr(bag_recorder, 'BagRecorderNode', lambda *_: made)
    bag_recorder.main()
    made.failure = 'not completed: so it is'
    with pytest.raises(SystemExit) as ended:
        bag_recorder.main()
    assert ended.value.code == REFUSED
    assert capsys.readouterr().err == 'bag_recorder: not completed: so it is\n'
