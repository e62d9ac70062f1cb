"""The bag recorder: writes all messages of the suite's topics into a bag, unchanged."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from math import inf
from operator import methodcaller
from pathlib import Path
import shutil
import sys
from typing import Any

from rclpy.node import Node

from bpc_interfaces.msg import DepositionPathUpdate
from bpc_perception.core.config import BagRecorderConfig
from bpc_perception.display.plain_text import one_line
from bpc_perception.messages import topics
from bpc_perception.messages.path import print_id_in
from bpc_perception.messages.poses.flange_poses import FlangePoses
from bpc_perception.nodes.parts.recording_watch import RecordingWatch
from bpc_perception.recording.bag_writer import BagWriter, begin_recording
from bpc_perception.recording.capture_packing import CapturePacker, Entry
from bpc_perception.recording.inputs import kept_beside
from bpc_perception.recording.print_bags import PrintBags
from bpc_perception.runtime.clock import steady_clock
from bpc_perception.runtime.diagnostics import Diagnostics
from bpc_perception.runtime.exit_status import REFUSED
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.run import run

FLUSH_PERIOD_S = 0.1  # a killed recorder loses this much, and what it had not received yet
BYTES_PER_GB = 1e9
PLACE_PERIOD_S = 1.0  # how often the recorder looks whether the recording is still in its place
QOS = {topics.POSE: topics.POSE_QOS, topics.JOINTS: topics.POSE_QOS,
       topics.LBR_STATE: topics.POSE_QOS, topics.EXTRUSION: topics.EXTRUSION_QOS,
       topics.PATH: topics.PATH_QOS, topics.NAV_PATH: topics.PATH_QOS,
       topics.SCHEDULE: topics.SCHEDULE_QOS,
       topics.PROFILE_UPDATE: topics.UPDATE_QOS, **dict.fromkeys(topics.CAMERA, topics.CAMERA_QOS),
       topics.CAMERA_INFO: topics.CAMERA_INFO_QOS}


class BagRecorderNode(Node):
    """Writes each message, still serialized, with the time at which it came.

    It makes one recording of all, or one of each print.

    Args:
        on_progress: is called after each flush with the number of messages by topic and the size
            of the file [bytes]. Its OSErrors do not matter.

    Attributes:
        failure: why the recording is not whole; empty = it is.
    """

    def __init__(self, on_progress: Callable[[dict[str, int], int], None] | None = None,
                 **kwargs: Any) -> None:
        super().__init__('bag_recorder', **kwargs)
        self._config = config = NodeConfig(self, BagRecorderConfig()).value
        beside = kept_beside(config.hand_eye_file, config.parameter_file, config.design_file)
        self.failure = ''
        self._on_progress = on_progress
        self._diagnostics = Diagnostics(self)
        self._path = self.resolve_topic_name(topics.PATH)
        captures = {name: self.resolve_topic_name(name) for name in topics.CAMERA}
        recorded = topics.CAMERA | topics.PRINT | topics.ROBOT | topics.RESULTS
        poses = FlangePoses(config.pose, '')
        needed = {topics.EXTRUSION}  # a recording is measured from these and its captures
        if config.pose.source != 'tf':  # poses of tf are not recorded, but the path is
            recorded[poses.topic] = poses.message_class
            needed.add(poses.topic)
        self._watch = RecordingWatch(self._diagnostics, captures,
                                     set(map(self.resolve_topic_name, needed)))
        for name, kind in recorded.items():
            self.create_subscription(
                kind, name, partial(self._write, self.resolve_topic_name(name)),
                QOS.get(name, topics.RESULT_QOS), raw=True)
        self.create_timer(FLUSH_PERIOD_S, self._flush, clock=steady_clock())
        self.create_timer(PLACE_PERIOD_S, self._check_place, clock=steady_clock())
        types = {self.resolve_topic_name(name): topics.type_name(kind)
                 for name, kind in recorded.items()}
        self._prints: PrintBags | None = None  # None = one recording of all
        self._packer: CapturePacker | None = None  # None = nothing is packed
        self._bag: BagWriter | PrintBags
        if config.prints:
            inputs = {self.resolve_topic_name(name) for name in recorded.keys() - topics.RESULTS}
            self._bag = self._prints = PrintBags(
                Path(config.prints), types, inputs, captures.values(), beside)
            self.create_subscription(
                DepositionPathUpdate, topics.PATH_UPDATE, partial(self._on_update, self._prints),
                topics.UPDATE_QOS)
        else:
            # The bag comes last: when the process is ended while it makes the node, no half-made
            # recording is left.
            if config.compress:
                self._packer = CapturePacker(
                    {topic: topics.CAMERA[name] for name, topic in captures.items()})
            self._bag = begin_recording(Path(config.bag), types, beside,
                                        self._packer.topics if self._packer else frozenset())
        self.get_logger().info(f'recording into {self._bag.path}')

    def _on_update(self, prints: PrintBags, message: DepositionPathUpdate) -> None:
        """Begin another recording if this is another print."""
        if message.path.print_id != prints.print_id:
            self.failure = ''
        try:
            if not self.failure:
                prints.follow(message.path.print_id, message.path.finished,
                              self.get_clock().now().nanoseconds)
        except OSError as error:
            self._fail(error)

    def _write(self, topic: str, data: bytes) -> None:
        if (self._prints is not None and topic == self._path
                and print_id_in(data) != self._prints.print_id):
            return  # a late one, of the print before
        entry = Entry(topic, self.get_clock().now().nanoseconds, data)
        if self._packer is None or not self._packer.take(entry):
            self._record(entry)
        self._record_packed()
        self._watch.heard(topic, data)

    def _record(self, entry: Entry) -> None:
        if not self.failure:
            try:
                self._bag.write(*entry)
            except OSError as error:
                self._fail(error)
        if self.failure:
            self._diagnostics.refuse(self.failure)  # so each lost message is counted
        else:
            self._diagnostics.count(entry.topic)

    def _record_packed(self) -> None:
        for entry in self._packer.packed() if self._packer else ():
            self._record(entry)

    def _flush(self) -> None:
        self._record_packed()
        try:
            if not self.failure:
                self._bag.flush()
        except OSError as error:
            self._fail(error)
        if self.failure:
            self._diagnostics.warn(self.failure)
        elif self._on_progress is not None:
            with suppress(OSError):  # the terminal is gone, or the disk that it asks about
                self._on_progress(*self._bag.written)
        self._watch.check()

    def _check_place(self) -> None:
        if not (self.failure or self._bag.in_place):
            self._diagnostics.warn(f'{self._bag.path}: expected the recording there, '
                                   'found it moved or removed; leave it until it is complete')
        if self._prints is not None and self._prints.print_id and not self.failure:
            free = inf  # where nobody can tell
            with suppress(OSError):
                free = shutil.disk_usage(self._prints.path).free / BYTES_PER_GB
            if free < self._config.least_free:
                self.failure = (f'not recorded: expected {self._config.least_free:g} GB free at '
                                f'{self._prints.path}, found {free:.1f}')

    def _fail(self, error: OSError, what: str = 'not recorded') -> None:
        """Record no more, but stay to say so: what is on disk can be read as it is."""
        self.failure = (f'{what}: expected to write {self._bag.path}, found: '
                        f'{error.strerror or error}')

    def complete(self) -> None:
        """Complete the bag."""
        for entry in self._packer.rest() if self._packer else ():
            self._record(entry)
        try:
            self._bag.close()
        except OSError as error:
            self._fail(error, 'not completed')

    def destroy_node(self) -> None:
        """Complete the bag as well."""
        self.complete()
        super().destroy_node()


def main(on_progress: Callable[[dict[str, int], int], None] | None = None) -> None:
    """Run the node; exit with 2 if the recording is not whole."""
    made: list[BagRecorderNode] = []

    def bag_recorder() -> BagRecorderNode:
        made.append(BagRecorderNode(on_progress))
        return made[0]

    run(bag_recorder, large_messages=True, fast_streams=True, complete=methodcaller('complete'))
    if made and made[0].failure:
        print(f'bag_recorder: {one_line(made[0].failure)}', file=sys.stderr)
        sys.exit(REFUSED)


if __name__ == '__main__':
    main()
