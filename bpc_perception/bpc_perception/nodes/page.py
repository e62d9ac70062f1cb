"""The page node: results, overlay and diagnostics in, a web page for people out."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from functools import partial
import os
import secrets
from typing import Any

import cv2
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from bpc_interfaces.msg import RateAdvice, ThicknessProfile
from bpc_perception.core.config import PageConfig
from bpc_perception.messages import topics
from bpc_perception.messages.advice import advice_from_message
from bpc_perception.messages.capture import image_to_rgb
from bpc_perception.messages.profile import profile_from_message
from bpc_perception.messages.stamps import ConversionError, stamp_to_ns
from bpc_perception.nodes.parts.goal_client import GoalClient
from bpc_perception.page import TOKEN_VARIABLE
from bpc_perception.page.board import Board, Level, overlay_of, TargetBand
from bpc_perception.page.server import PageServer
from bpc_perception.runtime.clock import on_jump_back, steady_clock
from bpc_perception.runtime.diagnostics import Diagnostics
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.process import limit_cpu_use
from bpc_perception.runtime.run import run

SERVICES = {'capture': 'capture', 'start': 'path_recorder/start', 'stop': 'path_recorder/stop',
            'save': 'path_recorder/save'}
GOAL_PERIOD = 5.0  # in which the target, which may be set anew, is asked for [s]
Outcome = tuple[bool, str]


class PageNode(Node):
    """Serves the page; while nobody looks it takes small messages only, and unpacks none.

    A profile is kept as it comes for whoever looks next. To the overlay, which is made only while
    someone listens, it listens while someone looks.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('page', **kwargs)
        config = NodeConfig(self, PageConfig()).value
        limit_cpu_use(config.process, self.get_logger())
        self._diagnostics = Diagnostics(self)
        self._board = Board(lambda: self.get_clock().now().nanoseconds)
        self._packed: bytes | None = None  # the newest profile, as long as nobody looks
        self._watchers = 0
        self._overlay: Any = None  # the subscription
        self._wanted: deque[tuple[str, Future[Outcome]]] = deque()
        self.create_subscription(ThicknessProfile, topics.PROFILE, self._on_profile,
                                 topics.RESULT_QOS, raw=True)
        self.create_subscription(RateAdvice, topics.ADVICE, self._on_advice, topics.RESULT_QOS)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 100)
        self._buttons = {name: self.create_client(Trigger, service)
                          for name, service in SERVICES.items()}
        self._goal = GoalClient(self, self._on_goal, self._diagnostics.warn)
        self.create_timer(GOAL_PERIOD, self._ask_for_goal, clock=steady_clock())
        self._jump = on_jump_back(self, self._board.clear)
        # What the server's thread wants is done in this node's.
        self._called = self.create_guard_condition(self._answer)
        given = os.environ.get(TOKEN_VARIABLE)
        self._server = PageServer(self._board, config.port, given or secrets.token_urlsafe(16),
                                  self._act, self._on_watchers)
        if not given:
            print(self._server.address, flush=True)  # not into the log, which is a topic too

    def _on_profile(self, packed: bytes) -> None:
        self._packed = packed
        self._diagnostics.count('profiles')
        self._unpack()

    def _unpack(self) -> None:
        if self._watchers and self._packed is not None:
            message = deserialize_message(self._packed, ThicknessProfile)
            self._packed = None
            with self._showing():
                self._board.profile = profile_from_message(message)

    def _on_advice(self, message: RateAdvice) -> None:
        with self._showing():
            self._board.advise(advice_from_message(message))

    def _on_overlay(self, message: Image) -> None:
        with self._showing():
            self._board.overlay = overlay_of(stamp_to_ns(message.header.stamp),
                                             image_to_rgb(message))

    @contextmanager
    def _showing(self) -> Iterator[None]:
        """Let the server know of something new, unless it has to be refused."""
        try:
            yield
        except ConversionError as error:
            self._diagnostics.refuse(error)
        except cv2.error as error:  # of a shape that makes no JPEG
            self._diagnostics.refuse(f'overlay: expected an image to show, found: {error}')
        else:
            self._server.notify()

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == self.get_name():
                continue  # whoever sees the page knows
            level = Level(min(ord(status.level), Level.STALE))
            self._board.hear(status.name, level, status.message)

    def _on_watchers(self, count: int) -> None:
        self._watchers = count
        self._called.trigger()

    def _act(self, name: str) -> Future[Outcome]:
        outcome: Future[Outcome] = Future()
        self._wanted.append((name, outcome))
        self._called.trigger()
        return outcome

    def _answer(self) -> None:
        self._diagnostics.note('browsers', self._watchers)
        if self._watchers and self._overlay is None:
            self._overlay = self.create_subscription(Image, topics.OVERLAY, self._on_overlay,
                                                     topics.VIEW_QOS)
            self._ask_for_goal()
        elif not self._watchers and self._overlay is not None:
            self.destroy_subscription(self._overlay)
            self._overlay = None
        self._unpack()
        while self._wanted:
            self._call(*self._wanted.popleft())

    def _call(self, name: str, outcome: Future[Outcome]) -> None:
        client = self._buttons[name]
        if not client.service_is_ready():
            outcome.set_result((False, f'nobody offers {client.srv_name}'))
            return
        client.call_async(Trigger.Request()).add_done_callback(partial(_pass_on, outcome))

    def _ask_for_goal(self) -> None:
        if self._watchers:
            self._goal.ask()

    def _on_goal(self, target: TargetBand | None) -> None:
        self._board.target = target
        self._server.notify()

    def destroy_node(self) -> None:
        """End the server as well."""
        self._server.close()
        super().destroy_node()


def _pass_on(outcome: Future[Outcome], answered: Any) -> None:
    answer = answered.result()
    if not outcome.cancelled():
        outcome.set_result((answer.success, answer.message or 'done'))


def main() -> None:
    """Run the node."""
    run(PageNode, large_messages=True)


if __name__ == '__main__':
    main()
