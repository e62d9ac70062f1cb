"""The thickness node: takes image, cloud and path, publishes thickness profile and rate advice."""

from __future__ import annotations

from collections import deque
from functools import partial
from threading import Event
import time
from typing import Any

from rclpy.node import Node

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.session import Session
from bpc_perception.files.design.wanted import wanted_design
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.messages import topics
from bpc_perception.messages.capture_pairing import CapturePairer
from bpc_perception.messages.stamps import ConversionError
from bpc_perception.nodes.parts.kept_learning import KeptLearning
from bpc_perception.nodes.parts.kept_setup import KeptSetup
from bpc_perception.nodes.parts.path_follower import PathFollower
from bpc_perception.nodes.parts.pose_source import subscribe_poses
from bpc_perception.nodes.parts.result_publisher import ResultPublisher
from bpc_perception.nodes.parts.single_source import subscribe_single_source
from bpc_perception.nodes.parts.views import Views
from bpc_perception.runtime.clock import expect_not_ahead, on_jump_back, steady_clock
from bpc_perception.runtime.diagnostics import Diagnostics, in_words
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.process import limit_cpu_use
from bpc_perception.runtime.run import run
from bpc_perception.runtime.transport.dds_profiles import lost_captures_hint

CAPTURES, SKIPPED = 'captures', 'captures skipped for newer ones'
BEFORE_PRINT = 'captures before a print'


class ThicknessNode(Node):
    """Measures each complete capture along the path; see docs/reference/nodes.

    Without ``camera_topics`` a camera driver in the same process hands captures over.
    """

    def __init__(self, camera_topics: bool = True, **kwargs: Any) -> None:
        super().__init__('thickness', **kwargs)
        self._config = NodeConfig(self, ThicknessConfig(), self._reconfigure)
        config = self._config.value
        limit_cpu_use(config.process, self.get_logger())
        hand_eye = load_hand_eye(config.hand_eye_file)
        self._diagnostics = Diagnostics(self, watch=config.watch)
        self._setup = KeptSetup(config.state_folder, self._now_ns, self._diagnostics.warn)
        self._learned = KeptLearning(config, self._diagnostics.warn)
        self._session = Session(config, hand_eye, self._setup.setup,
                                wanted_design(config.design), self._learned.told)
        self._pairer = CapturePairer()
        self._handed_over: deque[tuple[Capture, int, Event]] = deque()
        self._diagnostics.expect(CAPTURES, paced=True)
        self._frame = config.base_frame
        self._results = ResultPublisher(self, self._frame, bool(config.design.file))
        self._results.tell(self._session.schedule)
        self._views = Views(self, self._frame)
        self._ended = False  # the print
        for name, kind in topics.CAMERA.items() if camera_topics else ():
            qos = topics.CAMERA_INFO_QOS if name == topics.CAMERA_INFO else topics.CAMERA_QOS
            subscribe_single_source(self, kind, name, partial(self._on_camera, name), qos,
                                    self._diagnostics)
        if not hand_eye.on_base:
            subscribe_poses(self, config.pose, config.base_frame, config.watch.maximum_lead,
                            self._diagnostics, self._on_pose)
        self._path = PathFollower(self, self._frame, self._on_path, self._diagnostics.refuse)
        # Captures are measured when all messages that wait have been taken: the newest wins.
        self._news = self.create_guard_condition(self._publish_results)
        self.create_timer(0.1, self._check_waiting, clock=steady_clock())
        self._jump = on_jump_back(self, self._clear)

    def _on_camera(self, name: str, message: Any) -> None:
        try:
            capture = self._pairer.add(name, message, time.monotonic_ns())
        except (ConversionError, MemoryError) as error:
            self._diagnostics.refuse(in_words(error))
            return
        if capture is not None:
            self._diagnostics.count(SKIPPED, self._pairer.overtaken(capture.stamp_ns))
            self.hand_over(capture)

    def hand_over(self, capture: Capture) -> Event:
        """Take a capture, from any thread; return an event that is set when it had its turn."""
        turn = Event()
        self._diagnostics.heard(CAPTURES)
        self._handed_over.append((capture, time.monotonic_ns(), turn))
        self._news.trigger()
        return turn

    def _on_pose(self, stamp_ns: int, T_base_flange: Array) -> None:
        if not self._session.add_flange_pose(stamp_ns, T_base_flange):
            self._diagnostics.refuse('pose: expected one later than the last and within its '
                                     'reach, found it late, twice or a jump'
                                     '; let one robot alone publish, with its own stamps')

    def _on_path(self, path: DepositionPath) -> None:
        if not path.print_id:  # it was cleared
            self._forget_print()
            return
        self._session.set_path(path)
        self._ended = path.finished
        self._news.trigger()

    def _publish_results(self) -> None:
        turns = []
        while self._handed_over:
            capture, received_ns, turn = self._handed_over.popleft()
            self._diagnostics.count(CAPTURES)
            turns.append(turn)
            try:
                expect_not_ahead(self, 'capture', capture.stamp_ns,
                                 self._config.value.watch.maximum_lead)
            except ConversionError as error:
                self._diagnostics.refuse(error)
                continue
            self._session.add_capture(capture, received_ns)
        self._diagnostics.count(SKIPPED, self._session.skip_overtaken())
        self._measure()
        for turn in turns:
            turn.set()

    def _measure(self) -> None:
        for result in self._session.results(time.monotonic_ns()):
            if result.profile is None:
                if result.premature:
                    self._diagnostics.count(BEFORE_PRINT)
                    self._diagnostics.wait_for(result.refusal)
                else:
                    self._diagnostics.refuse(result.refusal)
                continue
            self._results.publish(result, self._config.value.longest_whole_profile)
            self._diagnostics.count('profiles')
            try:
                self._views.publish(result, self._config.value.overlay_layer)
            except MemoryError as error:
                self._diagnostics.refuse(in_words(error))
            if result.warning:
                self._diagnostics.warn(result.warning)
        if self._ended:
            self._results.complete()
        self._setup.keep(self._session.setup)
        self._learned.keep(self._session.schedule)

    def _now_ns(self) -> int:
        return int(self.get_clock().now().nanoseconds)

    def _check_waiting(self) -> None:
        self._news.trigger()
        patience_ns = round(self._config.value.patience * 1e9)
        before_ns = time.monotonic_ns() - patience_ns
        for problem in self._pairer.give_up(before_ns, lost_captures_hint()):
            self._diagnostics.refuse(problem)

    def _reconfigure(self, config: ThicknessConfig) -> None:
        self._session.config = config

    def _clear(self) -> None:
        self._handed_over.clear()
        self._path.clear()
        self._pairer.clear()
        self._forget_print()

    def _forget_print(self) -> None:
        """Forget what was received of the print, and tell those who know of it."""
        self._session.clear()
        if self._results.clear(self._now_ns(), self._session.schedule):
            self._views.clear()


def main() -> None:
    """Run the node."""
    run(ThicknessNode, large_messages=True)


if __name__ == '__main__':
    main()
