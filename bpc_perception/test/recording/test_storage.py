"""Recordings are read however they were stored, packed and left behind."""

from __future__ import annotations

from contextlib import closing
import logging
from pathlib import Path
import sqlite3

import pytest

pytest.importorskip('bpc_perception.recording.bag')
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import (
    CompressionFormat,
    CompressionMode,
    StoragePlugin,
    Writer,
)
from rosbags.typesys import get_typestore, Stores
from std_msgs.msg import String
import yaml
import zstandard

from bpc_perception.recording.bag import Bag, BagError

pytestmark = pytest.mark.ros
STRING = 'std_msgs/msg/String'
START_NS, MILLISECOND = 1_750_000_000 * 10**9, 10**6


def stored(folder: Path, plugin: StoragePlugin, count: int = 200,
           mode: CompressionMode = CompressionMode.NONE) -> Path:
    """A recording of numbered words, written by others, packed in one of the ways of rosbag2."""
    store = get_typestore(Stores.ROS2_JAZZY)
    text = store.types[STRING]
    writer = Writer(folder, version=9, storage_plugin=plugin)
    if mode != CompressionMode.NONE:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection('/words', STRING, typestore=store)
        for i in range(count):
            writer.write(connection, START_NS + i * MILLISECOND,
                         bytes(store.serialize_cdr(text(data=f'word {i}'), STRING)))
    return folder


def words_in(path: Path) -> list[int]:
    """Return the numbers of the words in the order in which they are read."""
    opened = Bag(path)
    return [int(message.data.removeprefix('word '))
            for _, _, message in opened.messages(set(opened.topics))]


PLUGINS = pytest.mark.parametrize('plugin', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])


@PLUGINS
@pytest.mark.parametrize('mode', [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_what_a_recorder_packed_is_read(tmp_path: Path, plugin: StoragePlugin,
                                        mode: CompressionMode) -> None:
    folder = stored(tmp_path / 'bag', plugin, mode=mode)
    assert words_in(folder) == list(range(200))
    (folder / 'metadata.yaml').unlink()  # which says how it was packed
    assert words_in(folder) == list(range(200))


@PLUGINS
def test_a_file_packed_or_unpacked_later_is_that_file(tmp_path: Path,
                                                      plugin: StoragePlugin) -> None:
    folder = stored(tmp_path / 'bag', plugin)
    file, = (path for path in folder.iterdir() if path.name != 'metadata.yaml')
    packed = file.with_name(f'{file.name}.zst')
    packed.write_bytes(zstandard.compress(file.read_bytes()))
    assert words_in(folder) == list(range(200))  # not twice
    file.unlink()
    assert words_in(folder) == list(range(200))
    assert words_in(packed) == list(range(200))


@PLUGINS
def test_a_damaged_packed_file_is_refused_and_nothing_stays(
        tmp_path: Path, plugin: StoragePlugin, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = stored(tmp_path / 'bag', plugin, mode=CompressionMode.FILE)
    file, = folder.glob('*.zstd')
    content = bytearray(file.read_bytes())
    content[4:40] = bytes(36)
    file.write_bytes(content)
    (tmp_path / 'tmp').mkdir()
    monkeypatch.setattr('tempfile.tempdir', str(tmp_path / 'tmp'))
    with pytest.raises(BagError, match='expected a file packed with zstd, found'):
        Bag(folder)
    assert list((tmp_path / 'tmp').iterdir()) == []


def test_a_damaged_packed_message_is_refused(tmp_path: Path) -> None:
    folder = stored(tmp_path / 'bag', StoragePlugin.SQLITE3, mode=CompressionMode.MESSAGE)
    database(folder, "UPDATE messages SET data = CAST(substr(data, 1, 9) AS BLOB) WHERE id = 7")
    with pytest.raises(BagError, match='expected a message packed with zstd, found'):
        words_in(folder)


@pytest.mark.parametrize('name', ['print #3 100% ok?', 'my cell (2)', '[run 1] ü', "it's; $HOME"])
@PLUGINS
def test_a_path_is_a_path(tmp_path: Path, plugin: StoragePlugin, name: str) -> None:
    stored(tmp_path / 'bag', plugin).rename(tmp_path / name)
    assert words_in(tmp_path / name) == list(range(200))


# sqlite3


def database(folder: Path, command: str, *values: int) -> None:
    """Change the sqlite3 file of a bag."""
    file, = folder.glob('*.db3')
    with closing(sqlite3.connect(file)) as opened, opened:
        opened.execute(command, values)


def test_a_sqlite_file_alone_will_do(tmp_path: Path) -> None:
    folder = stored(tmp_path / 'bag', StoragePlugin.SQLITE3)
    (folder / 'metadata.yaml').unlink()
    assert Bag(folder).topics == {'/words': STRING}
    assert Bag(folder).count('/words') == 200
    assert Bag(folder).span() == (START_NS, START_NS + 199 * MILLISECOND)
    assert words_in(folder) == list(range(200))


def test_a_sqlite_file_of_an_older_distribution_is_read(tmp_path: Path) -> None:
    folder = stored(tmp_path / 'bag', StoragePlugin.SQLITE3)
    database(folder, 'DROP TABLE message_definitions')
    assert words_in(folder) == list(range(200))


def test_a_torn_sqlite_file_is_read_up_to_the_damage(
        tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    folder = stored(tmp_path / 'bag', StoragePlugin.SQLITE3, count=2000)
    file, = folder.glob('*.db3')
    content = bytearray(file.read_bytes())
    content[len(content) // 2:len(content) // 2 + 8192] = bytes(8192)
    file.write_bytes(content)
    with caplog.at_level(logging.WARNING):
        found = words_in(folder)
    assert 200 < len(found) < 2000
    assert found == list(range(len(found)))
    assert 'torn, read up to the damage' in caplog.text


def test_sqlite_messages_come_in_the_order_of_recording(tmp_path: Path) -> None:
    folder = stored(tmp_path / 'bag', StoragePlugin.SQLITE3)
    database(folder, 'UPDATE messages SET timestamp = ? WHERE id = 101',
             START_NS + 60 * MILLISECOND + 1)
    assert words_in(folder) == [*range(61), 100, *range(61, 100), *range(101, 200)]


def test_where_the_clock_was_set_back_the_order_of_the_sqlite_file_counts(tmp_path: Path) -> None:
    folder = stored(tmp_path / 'bag', StoragePlugin.SQLITE3)
    database(folder, 'UPDATE messages SET timestamp = timestamp - ? WHERE id > 100',
             3600 * 10**9)
    assert words_in(folder) == list(range(200))


def test_what_a_killed_recorder_left_beside_a_sqlite_file_is_read(tmp_path: Path) -> None:
    folder = stored(tmp_path / 'bag', StoragePlugin.SQLITE3)
    file, = folder.glob('*.db3')
    writer = sqlite3.connect(file)
    writer.execute('PRAGMA journal_mode=WAL')
    data = serialize_message(String(data='word 200'))
    writer.execute('INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)',
                   (START_NS + 200 * MILLISECOND, data))
    writer.commit()
    try:
        assert list(folder.glob('*-wal'))
        assert words_in(folder) == list(range(201))
    finally:
        writer.close()


# Files that metadata.yaml lists


@PLUGINS
def test_a_listed_file_that_is_not_there_is_named(
        tmp_path: Path, plugin: StoragePlugin, caplog: pytest.LogCaptureFixture) -> None:
    folder = stored(tmp_path / 'bag', plugin)
    metadata = yaml.safe_load((folder / 'metadata.yaml').read_text())
    listed = metadata['rosbag2_bagfile_information']['relative_file_paths']
    listed.append('bag_1' + Path(listed[0]).suffix)
    (folder / 'metadata.yaml').write_text(yaml.safe_dump(metadata))
    with caplog.at_level(logging.WARNING):
        assert words_in(folder) == list(range(200))
    assert f'left out {listed[1]}, which metadata.yaml lists' in caplog.text


def test_a_long_metadata_file_is_read(tmp_path: Path) -> None:
    folder = stored(tmp_path / 'bag', StoragePlugin.MCAP)
    with (folder / 'metadata.yaml').open('a') as file:
        file.write('# of a robot with many topics\n' * 5000)
    (folder / 'copy.mcap').write_bytes(next(folder.glob('*.mcap')).read_bytes())
    assert words_in(folder) == list(range(200))  # the copy is not listed
