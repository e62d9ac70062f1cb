"""A recorder on a full disk, without poses, with a moved folder: it goes on and says so."""

from __future__ import annotations

import errno
import os
from pathlib import Path
import shutil
from types import SimpleNamespace
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
import pytest
from rclpy.node import Node
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image
from std_msgs.msg import String

from bpc_interfaces.msg import DepositionPathUpdate, ExtrusionState
from bpc_perception.messages import topics
from bpc_perception.nodes import bag_recorder
from bpc_perception.nodes.bag_recorder import BagRecorderNode
from bpc_perception.nodes.parts import recording_watch
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.bag_writer import BagWriter
from bpc_perception.runtime.exit_status import REFUSED
from bpc_perception.runtime.isolated_graph import Graph
from bpc_system_tests.parts.text_bags import STRING, texts, words
from bpc_system_tests.robustness.killed_recorder import counts


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
    monkeypatch.setattr(recording_watch, 'MISSING_INPUT_PATIENCE_S', 0.3)
    graph = Graph(ros_domain)
    try:
        (tmp_path / 'cell.yaml').write_text('{}')
        recorder = graph.make(BagRecorderNode, bag=str(tmp_path / 'bag'),
                              parameter_file=str(tmp_path / 'cell.yaml'))
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
        'without them the recording cannot be measured; start their nodes, or name their topics '
        'with --remap')
    assert (tmp_path / 'bag' / 'params.yaml').read_bytes() == b'{}'


def test_a_recorder_counts_captures_of_which_the_cloud_never_came(
        tmp_path: Path, ros_domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording_watch, 'TORN_PATIENCE_NS', 3 * 10**8)
    graph = Graph(ros_domain)
    try:
        recorder = graph.make(BagRecorderNode, bag=str(tmp_path / 'bag'))
        peer = graph.make(Node, 'peer')
        camera = {name: peer.create_publisher(kind, name, topics.CAMERA_QOS)
                  for name, kind in topics.CAMERA.items()}
        sent = 0

        def take_captures() -> bool:
            nonlocal sent
            sent += 1
            for name, publisher in camera.items():
                message = topics.CAMERA[name]()
                message.header.stamp.sec = sent
                if name != topics.CLOUD or sent % 2:
                    publisher.publish(message)
            counts = recorder._diagnostics._refusals
            return sum(counts.values()) >= 3

        graph.spin_until(take_captures)
        refused, = recorder._diagnostics._refusals
    finally:
        graph.close()
    assert refused == 'captures that are not recorded whole'


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
            f'{tmp_path / "bag"}: expected the recording there, found it moved or removed; leave '
            'it until it is complete')
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


def test_a_recorder_of_prints_whose_folder_is_removed_lives_and_records_the_next_print(
        tmp_path: Path, ros_domain: int) -> None:
    prints = tmp_path / 'prints'
    (tmp_path / 'cell.calib').write_text('{}')
    graph = Graph(ros_domain)
    try:
        recorder = graph.make(BagRecorderNode, prints=str(prints),
                              hand_eye_file=str(tmp_path / 'cell.calib'))

        def begin(print_id: str) -> None:
            update = DepositionPathUpdate()
            update.path.print_id = print_id
            recorder._on_update(recorder._prints, update)

        begin('one')
        shutil.rmtree(prints)
        recorder._check_place()
        assert 'found it moved or removed' in recorder._diagnostics._last_warning
        for _ in range(2):  # the first one finds that it cannot complete the recording before
            begin('two')
        assert recorder.failure == ''
        assert (prints / 'two' / 'recording' / 'hand_eye.calib').exists()
    finally:
        graph.close()
