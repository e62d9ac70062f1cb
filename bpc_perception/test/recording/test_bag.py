"""Recordings can be read after writing, by us and by others, and after damage."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
import shutil
import struct
import subprocess
import sys
import tracemalloc
from typing import Any

import lz4.frame
import numpy as np
from perception_builders import band_image, capture_of, path_through, profile_of, SECOND, START_NS
import pytest

bag = pytest.importorskip('bpc_perception.recording.bag')
from geometry_msgs.msg import PointStamped, Pose, PoseStamped  # noqa: E402
from mcap.writer import Writer as McapWriter  # noqa: E402
from rclpy.serialization import serialize_message  # noqa: E402
from rosbags.rosbag2 import Reader, StoragePlugin, Writer  # noqa: E402
from rosbags.typesys import get_types_from_msg, get_typestore, Stores  # noqa: E402
from std_msgs.msg import String  # noqa: E402
import yaml  # noqa: E402
import zstandard  # noqa: E402

from bpc_interfaces.msg import ExtrusionState, RateAdvice  # noqa: E402
from bpc_perception.core.config import RecorderConfig, ThicknessConfig  # noqa: E402
from bpc_perception.core.robot.hand_eye import HandEye  # noqa: E402
from bpc_perception.messages import topics  # noqa: E402
from bpc_perception.messages.capture import capture_to_messages  # noqa: E402
from bpc_perception.messages.path import path_to_message  # noqa: E402
from bpc_perception.messages.profile import profile_to_message  # noqa: E402
from bpc_perception.messages.types import (  # noqa: E402
    message_definition,
    message_type,
    MessageTypeError,
)
from bpc_perception.recording.bag import Bag, BagError  # noqa: E402
from bpc_perception.recording.bag_writer import BagWriter  # noqa: E402
from bpc_perception.recording.contents import (  # noqa: E402
    captures,
    find_topic,
    find_topics,
    is_recorded,
    pose_topics,
)
from bpc_perception.recording.offline import measure_bag  # noqa: E402
from bpc_perception.recording.storage.raw_message import Channel  # noqa: E402

pytestmark = pytest.mark.ros
OURS = ('DepositionPath', 'ExtrusionState', 'RateAdvice', 'ThicknessProfile')
STRING, POINT = 'std_msgs/msg/String', 'geometry_msgs/msg/PointStamped'
LBR_STATE = Channel('/lbr/state', 'lbr_fri_idl/msg/LBRState', b'float64 sample_time')


def point(number: int) -> PointStamped:
    message = PointStamped()
    message.header.frame_id = f'frame {number}'
    message.point.x = float(number)
    return message


def entries(count: int) -> list[tuple[str, int, Any]]:
    """Return points and words in turn, one each millisecond."""
    return [('/points', START_NS + i * 10**6, point(i)) if i % 2 == 0
            else ('/words', START_NS + i * 10**6, String(data=f'word {i}' * 50))
            for i in range(count)]


def write(path: Path, content: Iterable[tuple[str, int, Any]], **keywords: Any) -> Path:
    with BagWriter(path, **keywords) as writer:
        writer.add_topic('/points', POINT)
        writer.add_topic('/words', STRING)
        for topic, stamp_ns, message in content:
            writer.write(topic, stamp_ns, message)
    return path


def read(path: Path, wanted: set[str] | None = None) -> list[tuple[str, int, Any]]:
    opened = Bag(path)
    return list(opened.messages(set(opened.topics) if wanted is None else wanted))


def storage(folder: Path) -> Path:
    file, = folder.glob('*.mcap')
    return file


# Reading what was written


@pytest.mark.parametrize('compress', [False, True])
def test_what_was_written_is_read(tmp_path: Path, compress: bool) -> None:
    content = entries(40)
    folder = write(tmp_path / 'bag', content, compress=compress)
    assert Bag(folder).topics == {'/points': POINT, '/words': STRING}
    assert read(folder) == content


def test_the_file_alone_will_do(tmp_path: Path) -> None:
    assert read(storage(write(tmp_path / 'bag', entries(5)))) == entries(5)


def test_only_the_topics_asked_for_are_read(tmp_path: Path) -> None:
    found = read(write(tmp_path / 'bag', entries(6)), {'/words'})
    assert [topic for topic, _, _ in found] == ['/words'] * 3


@pytest.mark.parametrize('order', [
    lambda entry: (entry[0], entry[1]), lambda entry: (entry[1] // 10**7, -entry[1])],
    ids=['topic after topic', 'somewhat mixed'])
@pytest.mark.parametrize('compress', [False, True])
def test_messages_come_in_the_order_of_recording(
        tmp_path: Path, compress: bool, order: Callable[[tuple[str, int, Any]], Any]) -> None:
    content = entries(400)  # of several chunks
    folder = write(tmp_path / 'bag', sorted(content, key=order), compress=compress)
    assert read(folder) == content


def test_where_the_clock_was_set_back_the_order_of_the_file_counts(tmp_path: Path) -> None:
    content = [(topic, stamp_ns - (3600 * SECOND if index >= 200 else 0), message)
               for index, (topic, stamp_ns, message) in enumerate(entries(400))]
    assert read(write(tmp_path / 'bag', content)) == content


def split(folder: Path, names: Iterable[str],
          parts: Iterable[Iterable[tuple[str, int, Any]]], listed: bool = False) -> Path:
    """A recording in files of these names, of which metadata.yaml may list the order."""
    folder.mkdir()
    for name, part in zip(names, parts, strict=True):
        shutil.move(storage(write(folder / 'part', part)), folder / f'{name}.mcap')
        shutil.rmtree(folder / 'part')
    if listed:
        (folder / 'metadata.yaml').write_text(yaml.safe_dump({'rosbag2_bagfile_information': {
            'relative_file_paths': [f'{name}.mcap' for name in names]}}))
    return folder


def test_files_are_read_in_the_order_of_the_metadata_and_no_others(tmp_path: Path) -> None:
    content = entries(40)
    folder = split(tmp_path / 'bag', ('morning', 'late'), (content[:20], content[20:]), True)
    write(tmp_path / 'stray', entries(3))
    shutil.copy(storage(tmp_path / 'stray'), folder)
    assert [file.name for file in Bag(folder).files] == ['morning.mcap', 'late.mcap']
    assert read(folder) == content


def test_files_whose_messages_overlap_are_merged(tmp_path: Path) -> None:
    content = entries(60)
    late = content[20:30:2]
    first = [entry for entry in content[:30] if entry not in late]
    folder = split(tmp_path / 'bag', ('b_0', 'b_1', 'b_2'),
                   (first, [*content[30:35], *late, *content[35:50]], content[50:]))
    assert read(folder) == content


def test_a_file_into_which_nothing_came_spoils_no_recording(tmp_path: Path) -> None:
    content = entries(40)
    assert read(split(tmp_path / 'bag', ('b_0', 'b_1', 'b_2'),
                      (content[:20], content[20:], ()))) == content


def test_of_two_types_on_a_topic_the_more_frequent_is_read(tmp_path: Path) -> None:
    content = entries(10)
    with (tmp_path / 'bag.mcap').open('wb') as stream:
        writer = McapWriter(stream)
        writer.start('ros2')
        for topic, kind, count in (('/words', STRING, 5), ('/words', 'foxglove_msgs/msg/Log', 2),
                                   ('/points', 'geometry_msgs/PointStamped', 5)):
            schema = writer.register_schema(kind, 'ros2msg', b'')
            channel = writer.register_channel(topic, 'cdr', schema)
            chosen = [entry for entry in content if entry[0] == topic][:count]
            for _, stamp_ns, message in chosen:
                writer.add_message(channel, stamp_ns + count, serialize_message(message),
                                   stamp_ns)
        writer.finish()
    opened = Bag(tmp_path / 'bag.mcap')
    assert opened.topics == {'/words': STRING, '/points': POINT}  # a short name is as good
    assert [message for _, _, message in opened.messages(set(opened.topics))] == [
        message for _, _, message in content]


def test_serialized_messages_are_written_as_they_are(tmp_path: Path) -> None:
    folder = write(tmp_path / 'bag', [('/points', 1, serialize_message(point(3)))])
    assert read(folder) == [('/points', 1, point(3))]


def test_large_messages_keep_every_byte(tmp_path: Path) -> None:
    messages = capture_to_messages(capture_of(band_image()))
    names = list(topics.CAMERA)
    with BagWriter(tmp_path / 'bag') as writer:
        for name, kind in topics.CAMERA.items():
            writer.add_topic(f'/{name}', topics.type_name(kind))
        for name, message in zip(names, messages, strict=True):
            writer.write(f'/{name}', 5, message)
    assert [message for _, _, message in read(tmp_path / 'bag')] == list(messages)


def test_our_own_messages_are_read_back(tmp_path: Path) -> None:
    path = path_to_message(path_through(np.eye(3)), 'base')
    sizes = {name: np.ones(2) for name in ('height', 'height_sigma', 'area', 'area_sigma',
                                           'commanded_area')}
    profile = profile_to_message(replace(
        profile_of([1e-3, 2e-3]), **sizes, shift=np.zeros(3), tip_height=5e-4), 'base')
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/a', 'bpc_interfaces/msg/DepositionPath')
        writer.add_topic('/b', 'bpc_interfaces/msg/ThicknessProfile')
        writer.write('/a', 1, path)
        writer.write('/b', 2, profile)
    assert [message for _, _, message in read(tmp_path / 'bag')] == [path, profile]


def test_a_bag_without_messages_has_its_topics(tmp_path: Path) -> None:
    folder = write(tmp_path / 'bag', [])
    assert Bag(folder).topics == {'/points': POINT, '/words': STRING}
    assert read(folder) == []


def test_an_existing_folder_is_not_written_to(tmp_path: Path) -> None:
    with pytest.raises(BagError, match=r'expected a new bag, found that it exists'):
        BagWriter(tmp_path)
    assert list(tmp_path.iterdir()) == []


# Read by others


def test_rosbags_reads_what_we_wrote(tmp_path: Path) -> None:
    content = entries(11)
    folder = write(tmp_path / 'bag', content)
    store = get_typestore(Stores.ROS2_JAZZY)
    with Reader(folder) as reader:
        assert reader.message_count == 11
        assert reader.start_time == START_NS
        assert reader.end_time == START_NS + 10 * 10**6 + 1  # exclusive there
        assert {c.topic: (c.msgtype, c.msgcount) for c in reader.connections} == {
            '/points': (POINT, 6), '/words': (STRING, 5)}
        found = [(c.topic, stamp, store.deserialize_cdr(data, c.msgtype))
                 for c, stamp, data in reader.messages()]
    assert [(topic, stamp) for topic, stamp, _ in found] == [row[:2] for row in content]
    assert found[4][2].point.x == 4.0
    assert found[4][2].header.frame_id == 'frame 4'
    assert found[5][2].data == 'word 5' * 50


def test_the_metadata_is_that_of_jazzy(tmp_path: Path) -> None:
    folder = write(tmp_path / 'bag', entries(3))
    information = yaml.safe_load((folder / 'metadata.yaml').read_text())[
        'rosbag2_bagfile_information']
    assert information['version'] == 9
    assert information['storage_identifier'] == 'mcap'
    assert information['relative_file_paths'] == [storage(folder).name]
    assert information['duration']['nanoseconds'] == 2 * 10**6
    assert information['starting_time']['nanoseconds_since_epoch'] == START_NS
    assert information['message_count'] == 3
    assert information['ros_distro'] == 'jazzy'
    assert sorted(path.name for path in folder.iterdir()) == [
        storage(folder).name, 'metadata.yaml']


@pytest.mark.parametrize('name', OURS)
def test_our_definitions_are_complete(name: str) -> None:
    types = get_types_from_msg(message_definition(f'bpc_interfaces/msg/{name}'),
                               f'bpc_interfaces/msg/{name}')
    assert 'std_msgs/msg/Header' in types
    assert 'builtin_interfaces/msg/Time' in types


@pytest.mark.parametrize('name', OURS)
def test_rosbags_reads_our_messages_from_the_file_alone(tmp_path: Path, name: str) -> None:
    message = {
        'DepositionPath': path_to_message(path_through(np.eye(3)), ''),
        'ExtrusionState': ExtrusionState(flow_rate=3.0), 'RateAdvice': RateAdvice(reason=3),
        'ThicknessProfile': profile_to_message(profile_of([1e-3, 2e-3]), '')}[name]
    message.header.frame_id = 'here'
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/ours', f'bpc_interfaces/msg/{name}')
        writer.write('/ours', 1, message)
    store = get_typestore(Stores.EMPTY)
    with Reader(tmp_path / 'bag') as reader:
        connection, = reader.connections
        store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        (_, _, data), = reader.messages()
        assert store.deserialize_cdr(data, connection.msgtype).header.frame_id == 'here'


# Recordings of others


def sqlite_bag(path: Path, first: int = 0, count: int = 5) -> Path:
    store = get_typestore(Stores.ROS2_HUMBLE)
    text = store.types[STRING]
    with Writer(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection('/words', STRING, typestore=store)
        for i in range(first, first + count):
            writer.write(connection, START_NS + i,
                         bytes(store.serialize_cdr(text(data=f'word {i}'), STRING)))
    return path


def words(first: int, count: int) -> list[tuple[str, int, Any]]:
    return [('/words', START_NS + i, String(data=f'word {i}'))
            for i in range(first, first + count)]


def test_a_sqlite_bag_is_read(tmp_path: Path) -> None:
    folder = sqlite_bag(tmp_path / 'bag')
    assert Bag(folder).topics == {'/words': STRING}
    assert read(folder) == words(0, 5)
    file, = folder.glob('*.db3')
    assert read(file) == words(0, 5)


def test_a_sqlite_bag_of_several_files_is_read_once(tmp_path: Path) -> None:
    folder, other = sqlite_bag(tmp_path / 'bag'), sqlite_bag(tmp_path / 'more', first=5)
    first, = folder.glob('*.db3')
    second, = other.glob('*.db3')
    shutil.copy(second, folder / 'bag_1.db3')
    metadata = yaml.safe_load((folder / 'metadata.yaml').read_text())
    information = metadata['rosbag2_bagfile_information']
    information['relative_file_paths'] = [first.name, 'bag_1.db3']
    (folder / 'metadata.yaml').write_text(yaml.safe_dump(metadata))
    assert read(folder) == words(0, 10)


def test_mcap_files_of_a_split_bag_are_read_by_number(tmp_path: Path) -> None:
    (tmp_path / 'split').mkdir()
    for number in (2, 10, 9):
        part = write(tmp_path / f'part{number}', entries(number + 1)[number:])
        shutil.copy(storage(part), tmp_path / 'split' / f'split_{number}.mcap')
    stamps = [stamp for _, stamp, _ in read(tmp_path / 'split')]
    assert stamps == [START_NS + i * 10**6 for i in (2, 9, 10)]


# Damage


def write_plain(path: Path, count: int) -> tuple[Path, list[tuple[int, int]]]:
    """Write a bag that is flushed after every message; return where in the file each ended."""
    file = path / f'{path.name}_0.mcap'
    ends = []
    with BagWriter(path) as writer:
        writer.add_topic('/points', POINT)
        writer.add_topic('/words', STRING)
        for i, (topic, stamp_ns, message) in enumerate(entries(count)):
            writer.write(topic, stamp_ns, message)
            writer.flush()
            ends.append((file.stat().st_size, i))
    return file, ends


def test_a_torn_file_is_read_up_to_the_damage(tmp_path: Path) -> None:
    file, ends = write_plain(tmp_path / 'bag', 30)
    data, content = file.read_bytes(), entries(30)
    rng = np.random.default_rng(3)
    for cut in sorted(rng.integers(0, len(data), 50)):
        file.write_bytes(data[:cut])
        complete = sum(end <= cut for end, _ in ends)
        try:
            found = read(tmp_path / 'bag')
        except BagError:
            found = []
        assert found[:complete] == content[:complete], cut
        assert found == content[:len(found)]


@pytest.mark.parametrize('seed', range(4))
def test_flipped_bytes_are_survived(tmp_path: Path, seed: int) -> None:
    file, _ = write_plain(tmp_path / 'bag', 12)
    data, rng = file.read_bytes(), np.random.default_rng(seed)
    for _ in range(60):
        spoiled = bytearray(data)
        for place in rng.integers(0, len(data), 3):
            spoiled[place] ^= int(rng.integers(1, 256))
        file.write_bytes(spoiled)
        with suppress(BagError):  # no other error
            read(tmp_path / 'bag')


def test_a_writer_that_was_never_closed_leaves_what_was_flushed(tmp_path: Path) -> None:
    writer = BagWriter(tmp_path / 'bag')
    writer.add_topic('/points', POINT)
    for i in range(3):
        writer.write('/points', i, point(i))
    writer.flush()
    found = read(tmp_path / 'bag')
    assert found == [('/points', i, point(i)) for i in range(3)]
    writer.close()


def test_a_killed_writer_leaves_what_was_flushed(tmp_path: Path) -> None:
    script = f"""
import os
from std_msgs.msg import String
from bpc_perception.recording.bag_writer import BagWriter
writer = BagWriter({str(tmp_path / 'bag')!r})
writer.add_topic('/words', {STRING!r})
for i in range(5):
    writer.write('/words', i, String(data='x' * 100000))
writer.flush()
writer.write('/words', 5, String(data='lost'))
os._exit(9)
"""
    killed = subprocess.run([sys.executable, '-c', script], timeout=60, check=False)
    assert killed.returncode == 9
    found = read(tmp_path / 'bag')
    assert [stamp for _, stamp, _ in found][:5] == list(range(5))


def test_a_damaged_chunk_is_left_out(tmp_path: Path) -> None:
    file, _ = write_plain(tmp_path / 'bag', 10)
    data = bytearray(file.read_bytes())
    data[data.index(b'word 5')] ^= 1
    file.write_bytes(data)
    assert read(tmp_path / 'bag') == [entry for i, entry in enumerate(entries(10)) if i != 5]


def record(opcode: int, content: bytes, length: int | None = None) -> bytes:
    """Return a record of an MCAP file that states this length."""
    return struct.pack('<BQ', opcode, len(content) if length is None else length) + content


def chunk(compression: str, size: int, data: bytes, length: int | None = None) -> bytes:
    """Return a chunk that states this unpacked size."""
    return record(6, struct.pack('<QQQII', 0, 0, size, 0, len(compression))
                  + compression.encode()
                  + struct.pack('<Q', len(data) if length is None else length) + data)


ZEROS = bytes(1 << 28)


@pytest.mark.parametrize('content', [
    record(6, b'', 1 << 60), record(4, b'', 1 << 60), record(99, b'', 1 << 60),
    record(4, struct.pack('<HHI', 1, 1, 2**32 - 1) + b'name'),
    chunk('', 1 << 60, b'', 1 << 60), chunk('', 10, b'', 1 << 33),
    chunk('zstd', 1 << 60, zstandard.compress(ZEROS)),
    chunk('zstd', 1000, zstandard.compress(ZEROS)),
    chunk('lz4', 1000, lz4.frame.compress(ZEROS)), chunk('bzip2', 10, b'x')],
    ids=['chunk', 'channel', 'unknown', 'string', 'data', 'more data', 'zstd', 'zstd of zeros',
         'lz4 of zeros', 'unknown compression'])
def test_a_length_that_lies_takes_no_memory(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / 'bag.mcap'
    file.write_bytes(b'\x89MCAP0\r\n' + record(1, struct.pack('<II', 0, 0)) + content)
    tracemalloc.start()
    try:
        with pytest.raises(BagError, match='expected an MCAP file with messages, found none'):
            Bag(file)
        assert tracemalloc.get_traced_memory()[1] < 50e6
    finally:
        tracemalloc.stop()


# No recording


def test_a_missing_path_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BagError, match=r'none: expected a bag, found nothing there'):
        Bag(tmp_path / 'none')


def test_an_empty_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BagError, match=r'expected a rosbag2 folder or .*, found neither'):
        Bag(tmp_path)


@pytest.mark.parametrize('content', [b'', b'just some words\n', b'\x89MCAP0\r\n', bytes(5000),
                                     b'\xff' * 300],
                         ids=['empty', 'text', 'magic only', 'zeros', 'ones'])
def test_a_file_that_is_no_mcap_is_refused(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / 'bag.mcap'
    file.write_bytes(content)
    with pytest.raises(BagError, match=r'bag\.mcap: expected an MCAP file .*found'):
        Bag(file)


def test_a_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    file = tmp_path / 'notes.txt'
    file.write_text('words')
    with pytest.raises(BagError, match=r'notes\.txt: expected .*found neither'):
        Bag(file)


def test_a_file_beside_a_sqlite_bag_is_a_recording_by_itself(tmp_path: Path) -> None:
    folder, other = sqlite_bag(tmp_path / 'bag'), sqlite_bag(tmp_path / 'more', first=5)
    file, = other.glob('*.db3')
    shutil.copy(file, folder / 'stray.db3')
    assert read(folder / 'stray.db3') == words(5, 5)
    assert read(folder) == words(0, 5)


def test_a_file_that_is_no_sqlite_bag_is_refused(tmp_path: Path) -> None:
    folder = sqlite_bag(tmp_path / 'bag')
    file, = folder.glob('*.db3')
    file.write_bytes(b'nothing of the kind' * 100)
    with pytest.raises(BagError, match=r'expected .*sqlite3.*found'):
        read(folder)


@pytest.mark.parametrize('name', ['no_such_msgs/msg/Thing', 'std_msgs/msg/Thing', 'Thing', '',
                                  'std_msgs/Thing'])
def test_an_unknown_type_is_refused(name: str) -> None:
    with pytest.raises(MessageTypeError, match=rf'expected one that is installed, found {name}'):
        message_type(name)
    with pytest.raises(MessageTypeError, match=rf'expected one that is installed, found {name}'):
        message_definition(name)


def test_a_message_of_another_type_is_refused(tmp_path: Path) -> None:
    folder = write(tmp_path / 'bag', [('/points', 1, b'\x00\x01\x00\x00\xff')])
    with pytest.raises(BagError, match=rf'expected a {POINT} on /points, found 5 other bytes'):
        read(folder)


# The recording of a print


def recording(path: Path, stamps: Iterable[float], prefix: str = '/cell',
              leave_out: str = '') -> Bag:
    """Write a bag of captures, recorded a second after their stamps."""
    with BagWriter(path) as writer:
        for name, kind in topics.CAMERA.items():
            writer.add_topic(f'{prefix}/{name}', topics.type_name(kind))
        for stamp in stamps:
            stamp_ns = START_NS + round(stamp * SECOND)
            messages = capture_to_messages(capture_of(band_image(), stamp_ns))
            for name, message in zip(topics.CAMERA, messages, strict=True):
                if name != leave_out or stamp != 2:
                    writer.write(f'{prefix}/{name}', stamp_ns + SECOND, message)
    return Bag(path)


def test_captures_are_found_in_any_namespace(tmp_path: Path) -> None:
    found = list(captures(recording(tmp_path / 'bag', (1, 2, 3))))
    assert [log_ns - capture.stamp_ns for log_ns, capture in found] == [SECOND] * 3
    assert [capture.stamp_ns for _, capture in found] == [START_NS + i * SECOND for i in (1, 2, 3)]
    np.testing.assert_array_equal(found[0][1].image, band_image())


@pytest.mark.parametrize('name', list(topics.CAMERA))
def test_an_incomplete_capture_is_left_out(tmp_path: Path, name: str) -> None:
    found = list(captures(recording(tmp_path / 'bag', (1, 2, 3), leave_out=name)))
    assert [capture.stamp_ns for _, capture in found] == [START_NS + i * SECOND for i in (1, 3)]


def test_a_recording_without_a_camera_is_refused(tmp_path: Path) -> None:
    opened = Bag(write(tmp_path / 'bag', entries(2)))
    with pytest.raises(BagError, match=r'expected one topic color/image_color .*found none among '
                                       r'/points, /words'):
        list(captures(opened))


def test_a_name_that_two_topics_have_is_refused(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as writer:
        for cell in 'ab':
            writer.add_topic(f'/{cell}/extrusion_state', 'bpc_interfaces/msg/ExtrusionState')
    with pytest.raises(BagError, match=r'expected one topic .*found /a/extrusion_state and /b/.*; '
                                       r'choose one with --remap extrusion_state:=TOPIC'):
        find_topic(Bag(tmp_path / 'bag'), topics.EXTRUSION, ExtrusionState)


@pytest.mark.parametrize('other', ['/b/extrusion_state', 'b/extrusion_state'])
def test_another_topic_is_read_in_its_place(tmp_path: Path, other: str) -> None:
    with BagWriter(tmp_path / 'bag') as writer:
        for name in ('a/extrusion_state', 'b/extrusion_state', 'extrusion_state'):
            writer.add_topic(f'/{name}', 'bpc_interfaces/msg/ExtrusionState')
    opened = Bag(tmp_path / 'bag', {topics.EXTRUSION: other})
    assert find_topic(opened, topics.EXTRUSION, ExtrusionState) == '/b/extrusion_state'
    nowhere = Bag(tmp_path / 'bag', {topics.EXTRUSION: 'c/extrusion_state'})
    with pytest.raises(BagError, match=r'expected one topic c/extrusion_state .*none among'):
        find_topic(nowhere, topics.EXTRUSION, ExtrusionState)


@pytest.mark.parametrize('topic', ['/extrusion_state', '/cell/extrusion_state',
                                   'extrusion_state'])
def test_a_topic_is_found_by_its_relative_name(tmp_path: Path, topic: str) -> None:
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic(topic, 'bpc_interfaces/msg/ExtrusionState')
        writer.add_topic('/my_extrusion_state', 'bpc_interfaces/msg/ExtrusionState')
    opened = Bag(tmp_path / 'bag')
    assert find_topic(opened, topics.EXTRUSION, ExtrusionState) == topic
    assert find_topics(opened, {topics.EXTRUSION: ExtrusionState}) == {topic: topics.EXTRUSION}


def test_a_type_that_has_one_meaning_is_found_by_any_name(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/plunger/state', 'bpc_interfaces/msg/ExtrusionState')
        writer.add_topic('/tool', 'geometry_msgs/msg/PoseStamped')
    opened = Bag(tmp_path / 'bag')
    assert find_topic(opened, topics.EXTRUSION, ExtrusionState) == '/plunger/state'
    with pytest.raises(BagError, match='expected one topic end_effector_pose'):
        find_topic(opened, topics.POSE, PoseStamped)


def test_a_topic_without_messages_is_not_recorded(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/extrusion_state', 'bpc_interfaces/msg/ExtrusionState')
    assert not is_recorded(Bag(tmp_path / 'bag'), topics.EXTRUSION, ExtrusionState)
    with BagWriter(tmp_path / 'other') as writer:
        writer.add_topic('/extrusion_state', 'bpc_interfaces/msg/ExtrusionState')
        writer.write('/extrusion_state', 1, ExtrusionState())
    assert is_recorded(Bag(tmp_path / 'other'), topics.EXTRUSION, ExtrusionState)
    assert not is_recorded(Bag(tmp_path / 'other'), topics.POSE, PoseStamped)


def test_all_that_was_recorded_of_the_poses_is_found(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'lbr_fri_idl', None)
    monkeypatch.setitem(sys.modules, 'lbr_fri_idl.msg', None)
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/end_effector_pose', 'geometry_msgs/msg/Pose')
        writer.add_topic('/lbr/joint_states', 'sensor_msgs/msg/JointState')
        writer.add_channel(LBR_STATE)
        writer.write('/end_effector_pose', 1, Pose())
    assert pose_topics(Bag(tmp_path / 'bag')) == {topics.POSE: Pose}
    with BagWriter(tmp_path / 'lbr') as writer:
        writer.add_channel(LBR_STATE)
    with pytest.raises(MessageTypeError,
                       match='expected one that is installed, found lbr_fri_idl'):
        pose_topics(Bag(tmp_path / 'lbr'))


def test_what_was_to_be_recorded_but_was_not_is_named(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as writer:
        for name, kind in (topics.CAMERA | topics.PRINT).items():
            writer.add_topic(f'/{name}', topics.type_name(kind))
    with pytest.raises(BagError, match='expected messages on /end_effector_pose and '
                                       '/extrusion_state, found none'):
        list(measure_bag(Bag(tmp_path / 'bag'), HandEye(True, np.eye(4)), ThicknessConfig(),
                         RecorderConfig()))


def test_a_topic_of_another_type_does_not_count(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('/extrusion_state', STRING)
    with pytest.raises(BagError, match=r'found none among /extrusion_state'):
        find_topic(Bag(tmp_path / 'bag'), topics.EXTRUSION, RateAdvice)
