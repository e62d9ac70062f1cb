"""A recovered recording has all that the torn one says of itself."""

from __future__ import annotations

from pathlib import Path
import sqlite3

from mcap.reader import make_reader
import pytest

pytest.importorskip('bpc_perception.recording.bag')
from mcap.writer import CompressionType, Writer
from rclpy.serialization import serialize_message
from std_msgs.msg import Int32, String
import yaml

from bpc_perception.recording.bag import Bag
from bpc_perception.recording.recovery import recover_bag

pytestmark = pytest.mark.ros
QOS = '- history: keep_last\n  depth: 5\n  reliability: best_effort\n'


@pytest.fixture
def torn(tmp_path: Path) -> Path:
    """A torn recording by somebody else, with much that bpc does not use."""
    folder = tmp_path / 'torn'
    folder.mkdir()
    with (folder / 'part_0.mcap').open('wb') as stream:
        writer = Writer(stream, compression=CompressionType.LZ4)
        writer.start('ros2')
        writer.add_metadata('cell', {'operator': 'night shift'})
        writer.add_metadata('rosbag2', {'serialized_metadata': 'of 3 messages'})
        writer.add_attachment(5, 6, 'mesh.stl', 'model/stl', b'solid')
        text = writer.register_schema('std_msgs/msg/String', 'ros2msg', b'string data')
        other = writer.register_schema('std_msgs/msg/Int32', 'ros2idl', b'struct Int32 {};')
        plain = writer.register_schema('Notes', 'jsonschema', b'{}')
        words = writer.register_channel('/a', 'cdr', text, {'offered_qos_profiles': QOS,
                                                            'topic_type_hash': 'RIHS01_12'})
        numbers = writer.register_channel('/a', 'cdr', other)
        notes = writer.register_channel('/notes', 'json', plain)
        for i in range(5):
            writer.add_message(words, 100 + i, serialize_message(String(data=f'{i}')), 50 + i, i)
        writer.add_message(numbers, 200, serialize_message(Int32(data=7)), 150, 9)
        writer.add_message(notes, 300, b'{"a": 1}', 250, 0)
        writer.finish()
    file = folder / 'part_0.mcap'
    file.write_bytes(file.read_bytes()[:-60])  # without its summary
    (folder / 'metadata.yaml').write_text(yaml.safe_dump({'rosbag2_bagfile_information': {
        'relative_file_paths': ['part_0.mcap'], 'ros_distro': 'humble',
        'custom_data': {'sample': '12b'}}}))
    (folder / 'notes.txt').write_text('mine')
    (folder / 'params.yaml').write_text('{}')
    return folder


def test_what_is_not_understood_is_kept(torn: Path, tmp_path: Path) -> None:
    recover_bag(torn, tmp_path / 'whole')
    with (tmp_path / 'whole' / 'whole_0.mcap').open('rb') as stream:
        reader = make_reader(stream)
        found = [(schema.name, schema.encoding, schema.data, channel.topic,
                  channel.message_encoding, message.log_time, message.publish_time,
                  message.sequence) for schema, channel, message in reader.iter_messages()]
        qos = {channel.topic: channel.metadata for _, channel, _ in reader.iter_messages()
               if channel.metadata}
        attached = [(each.name, each.media_type, each.create_time, each.log_time, each.data)
                    for each in reader.iter_attachments()]
        metadata = [(each.name, each.metadata) for each in reader.iter_metadata()]
    assert found[4:] == [
        ('std_msgs/msg/String', 'ros2msg', b'string data', '/a', 'cdr', 104, 54, 4),
        ('std_msgs/msg/Int32', 'ros2idl', b'struct Int32 {};', '/a', 'cdr', 200, 150, 9),
        ('Notes', 'jsonschema', b'{}', '/notes', 'json', 300, 250, 0)]
    assert qos == {'/a': {'offered_qos_profiles': QOS, 'topic_type_hash': 'RIHS01_12'}}
    assert attached == [('mesh.stl', 'model/stl', 5, 6, b'solid')]
    assert metadata == [('cell', {'operator': 'night shift'})]


def test_the_new_description_has_what_the_old_one_said(torn: Path, tmp_path: Path) -> None:
    recover_bag(torn, tmp_path / 'whole')
    said = yaml.safe_load((tmp_path / 'whole' / 'metadata.yaml').read_text())[
        'rosbag2_bagfile_information']
    assert (said['message_count'], said['ros_distro']) == (7, 'humble')
    assert said['custom_data'] == {'sample': '12b'}
    topics = [(each['topic_metadata']['type'], each['topic_metadata']['serialization_format'],
               each['topic_metadata']['offered_qos_profiles'], each['message_count'])
              for each in said['topics_with_message_count']]
    assert topics == [('std_msgs/msg/String', 'cdr', yaml.safe_load(QOS), 5),
                      ('std_msgs/msg/Int32', 'cdr', [], 1), ('Notes', 'json', [], 1)]


def test_what_is_left_out_is_named(torn: Path, tmp_path: Path) -> None:
    found = recover_bag(torn, tmp_path / 'whole')
    assert found.messages == {'/a': 6, '/notes': 1}
    assert found.left_out == ['notes.txt']
    assert {path.name for path in (tmp_path / 'whole').iterdir()} == {
        'whole_0.mcap', 'metadata.yaml', 'params.yaml'}
    assert recover_bag(torn / 'part_0.mcap', tmp_path / 'of the file').left_out == []


def test_a_sqlite_recording_is_recovered(tmp_path: Path) -> None:
    file = tmp_path / 'left.db3'
    database = sqlite3.connect(file)
    database.executescript(
        'CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, '
        'serialization_format TEXT, offered_qos_profiles TEXT); CREATE TABLE messages('
        'id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);')
    database.execute('INSERT INTO topics VALUES (1, ?, ?, ?, ?)',
                     ('/a', 'std_msgs/msg/String', 'cdr', QOS))
    for i in range(3):
        database.execute('INSERT INTO messages VALUES (?, 1, ?, ?)',
                         (i, 100 + i, serialize_message(String(data=f'{i}'))))
    database.commit()
    database.close()
    recover_bag(file, tmp_path / 'whole')
    opened = Bag(tmp_path / 'whole')
    assert [(log_ns, message.data) for _, log_ns, message in opened.messages({'/a'})] == [
        (100, '0'), (101, '1'), (102, '2')]
    with (tmp_path / 'whole' / 'whole_0.mcap').open('rb') as stream:
        (channel,) = make_reader(stream).get_summary().channels.values()
    assert channel.metadata == {'offered_qos_profiles': QOS}
