"""The bag recorder: everything that the suite's topics carry, as it is, into a bag."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from math import inf
import sys
import time
from typing import Any

from rclpy.node import Node

from bpc_perception.core.config import BagRecorderConfig
from bpc_perception.messages import topics
from bpc_perception.messages.flange_poses import FlangePoses
from bpc_perception.recording.bag_writer import BagWriter
from bpc_perception.runtime.clock import steady_clock
from bpc_perception.runtime.diagnostics import Diagnostics
from bpc_perception.runtime.exit_status import REFUSED
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.run import run

FLUSH_PERIOD = 0.1  # what a killed recorder loses, and what it had not yet taken in [s]
PLACE_PERIOD = 1.0  # in which is looked whether the recording is still where it was begun [s]
# From a capture until what has not been heard beside it is missed [s].
PATIENCE = 3.0
QOS = {topics.POSE: topics.POSE_QOS, topics.JOINTS: topics.POSE_QOS,
       topics.LBR_STATE: topics.POSE_QOS, topics.EXTRUSION: topics.EXTRUSION_QOS,
       topics.PATH: topics.PATH_QOS, topics.NAV_PATH: topics.PATH_QOS}


class BagRecorderNode(Node):
    """Writes each message, still serialized, at the time it came.

    ``on_progress``, if given, is called after each flush with the messages by topic and the size
    of the file; what fails in it does not matter. ``beside`` are further files of the recording,
    name to content.

    Attributes:
        failure: why the recording is not whole; empty = it is.
    """

    def __init__(self, on_progress: Callable[[dict[str, int], int], None] | None = None,
                 beside: Mapping[str, bytes] | None = None, **kwargs: Any) -> None:
        super().__init__('bag_recorder', **kwargs)
        config = NodeConfig(self, BagRecorderConfig()).value
        self.failure = ''
        self._on_progress = on_progress
        self._diagnostics = Diagnostics(self)
        recorded = {}
        wanted = topics.CAMERA | topics.PRINT | topics.ROBOT | topics.RESULTS
        poses = FlangePoses(config.pose, '')
        if config.pose.source != 'tf':  # of which a recording has the path
            wanted[poses.topic] = poses.message_class
        # What a recording is measured from beside its captures.
        self._first_capture = inf  # [s], steady
        self._camera = self.resolve_topic_name(topics.IMAGE)
        self._needed = {self.resolve_topic_name(name)
                        for name in (poses.topic, topics.EXTRUSION) if name in wanted}
        for name, kind in wanted.items():
            qos = QOS.get(name, topics.CAMERA_QOS if name in topics.CAMERA else topics.RESULT_QOS)
            full = self.resolve_topic_name(name)
            recorded[full] = topics.type_name(kind)
            self.create_subscription(kind, name, partial(self._write, full), qos, raw=True)
        self.create_timer(FLUSH_PERIOD, self._flush, clock=steady_clock())
        self.create_timer(PLACE_PERIOD, self._look_for_it, clock=steady_clock())
        # Last, since who is told to end while it makes a node leaves it half made.
        self._bag = BagWriter(config.bag)
        try:
            for full, type_name in recorded.items():
                self._bag.add_topic(full, type_name)
            for name, content in (beside or {}).items():
                (self._bag.path / name).write_bytes(content)
        except BaseException:
            self._bag.close()
            raise
        self.get_logger().info(f'recording into {config.bag}')

    def _write(self, topic: str, data: bytes) -> None:
        if not self.failure:
            try:
                self._bag.write(topic, self.get_clock().now().nanoseconds, data)
            except OSError as error:
                self._fail(error)
        if self.failure:
            self._diagnostics.refuse(self.failure)  # each message that is lost is counted
        else:
            self._diagnostics.count(topic)
        self._needed.discard(topic)
        if topic == self._camera:
            self._first_capture = min(self._first_capture, time.monotonic())

    def _flush(self) -> None:
        try:
            if not self.failure:
                self._bag.flush()
        except OSError as error:
            self._fail(error)
        if self.failure:
            self._diagnostics.warn(self.failure)
        elif self._on_progress is not None:
            with suppress(OSError):  # the terminal is gone, or what it asks the disk for
                self._on_progress(*self._bag.written)
        if self._needed and time.monotonic() > self._first_capture + PATIENCE:
            self._diagnostics.warn(
                f'{" and ".join(sorted(self._needed))}: expected messages beside the captures, '
                'found none; without them the recording cannot be measured')
            self._needed.clear()

    def _look_for_it(self) -> None:
        if not (self.failure or self._bag.in_place):
            self._diagnostics.warn(f'{self._bag.path}: expected the recording there, '
                                   'found it moved or removed')

    def _fail(self, error: OSError, what: str = 'not recorded') -> None:
        """Record no more, but stay, to say so: what is on disk is readable as it is."""
        self.failure = (f'{what}: expected to write {self._bag.path}, found: '
                        f'{error.strerror or error}')

    def destroy_node(self) -> None:
        """Complete the bag as well."""
        try:
            self._bag.close()
        except OSError as error:
            self._fail(error, 'not completed')
        finally:
            super().destroy_node()


def main(on_progress: Callable[[dict[str, int], int], None] | None = None,
         beside: Mapping[str, bytes] | None = None) -> None:
    """Run the node; exit with 2 if the recording is not whole."""
    made: list[BagRecorderNode] = []

    def bag_recorder() -> BagRecorderNode:
        made.append(BagRecorderNode(on_progress, beside))
        return made[0]

    run(bag_recorder, large_messages=True, fast_streams=True)
    if made and made[0].failure:
        print(f'bag_recorder: {made[0].failure}', file=sys.stderr)
        sys.exit(REFUSED)


if __name__ == '__main__':
    main()
