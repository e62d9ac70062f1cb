"""Fuzz targets: recordings."""

from __future__ import annotations

from pathlib import Path
import shutil

from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores

from bpc_perception.messages import topics
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.bag_writer import BagWriter
from bpc_system_tests.robustness.fuzz_targets.sample_messages import recorded_messages
from bpc_system_tests.robustness.fuzz_targets.target import Run

SEPARATOR = b'\n# end of metadata\n'  # between metadata and database


def mcap_seeds(folder: Path) -> list[bytes]:
    """Return a recording of ours, one with compressed chunks, and a torn one."""
    seeds = []
    for compress in (False, True):
        with BagWriter(folder / f'seed_{compress}', compress=compress) as writer:
            for name, message in recorded_messages():
                writer.add_topic(f'/{name}', topics.type_name(type(message)))
            for number, (name, message) in enumerate(recorded_messages()):
                writer.write(f'/{name}', number, message)
                writer.flush()
        file, = Bag(writer.path).files
        seeds.append(file.read_bytes())
    return [*seeds, seeds[0][:len(seeds[0]) // 2]]


def bag_reader(folder: Path) -> Run:
    """Return a reader that opens an MCAP file and reads all of it."""
    file = folder / 'spoiled.mcap'

    def run(data: bytes) -> object:
        file.write_bytes(data)
        bag = Bag(file)
        bag.span()
        return sum(1 for _ in bag.messages(set(bag.topics)))
    return run


def sqlite_seed(folder: Path) -> bytes:
    """Return metadata and database of a bag, one after the other."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    text = store.types['std_msgs/msg/String']
    with Writer(folder / 'sqlite', version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection('/words', 'std_msgs/msg/String', typestore=store)
        for number in range(3):
            writer.write(connection, number, bytes(store.serialize_cdr(
                text(data=f'word {number}'), 'std_msgs/msg/String')))
    database, = (folder / 'sqlite').glob('*.db3')
    return (folder / 'sqlite' / 'metadata.yaml').read_bytes() + SEPARATOR + database.read_bytes()


def sqlite_reader(folder: Path) -> Run:
    """Return a reader that opens a bag with metadata and SQLite database and reads all of it."""
    bag = folder / 'spoiled'

    def run(data: bytes) -> object:
        metadata, _, database = data.partition(SEPARATOR)
        shutil.rmtree(bag, ignore_errors=True)
        bag.mkdir()
        (bag / 'metadata.yaml').write_bytes(metadata)
        (bag / 'sqlite.db3').write_bytes(database)
        opened = Bag(bag)
        return sum(1 for _ in opened.messages(set(opened.topics)))
    return run
