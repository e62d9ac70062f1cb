"""The page node: takes results, overlay and diagnostics, serves a web page for people."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import os
import secrets
from typing import Any

import cv2
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from sensor_msgs.msg import Image

from bpc_interfaces.msg import DesignComparison, PrintVerdict, RateAdvice
from bpc_perception.core.config import PageConfig
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.messages import topics
from bpc_perception.messages.capture import image_to_rgb
from bpc_perception.messages.results.advice import advice_from_message
from bpc_perception.messages.results.design import design_from_message
from bpc_perception.messages.results.verdict import verdict_from_message
from bpc_perception.messages.stamps import ConversionError, stamp_to_ns
from bpc_perception.nodes.parts.profile_follower import ProfileFollower
from bpc_perception.nodes.parts.target_client import TargetClient
from bpc_perception.nodes.parts.trigger_services import TriggerServices
from bpc_perception.page import TOKEN_VARIABLE
from bpc_perception.page.board import Board, Level, overlay_of, TargetBand
from bpc_perception.page.server import PageServer
from bpc_perception.runtime.clock import on_jump_back, steady_clock
from bpc_perception.runtime.diagnostics import Diagnostics
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.process import limit_cpu_use
from bpc_perception.runtime.run import run

# The buttons of the page, each with its service.
BUTTON_SERVICES = {'capture': 'capture', 'start': 'path_recorder/start',
                   'stop': 'path_recorder/stop', 'save': 'path_recorder/save'}
NO_VIEW_BYTES = 3  # of the picture that stands for none
TARGET_PERIOD_S = 5.0  # how often the target is asked for, since it can be changed


class PageNode(Node):
    """Serves the page. While nobody looks, it takes small messages only, and unpacks none.

    The newest profile is kept packed until someone looks. The node subscribes to the overlay only
    while someone looks, because the overlay is made only while someone subscribes.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('page', **kwargs)
        config = NodeConfig(self, PageConfig()).value
        limit_cpu_use(config.process, self.get_logger())
        self._diagnostics = Diagnostics(self)
        self._board = Board(lambda: self.get_clock().now().nanoseconds)
        self._watchers = 0
        self._overlay: Any = None  # the subscription
        self._profiles = ProfileFollower(self, self._on_profile, self._diagnostics.refuse)
        self._profiles.pause(True)  # nobody looks yet
        self.create_subscription(RateAdvice, topics.ADVICE, self._on_advice, topics.RESULT_QOS)
        self.create_subscription(PrintVerdict, topics.VERDICT, self._on_verdict, topics.RESULT_QOS)
        self.create_subscription(
            DesignComparison, topics.DESIGN, self._on_design, topics.RESULT_QOS)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 100)
        services = TriggerServices(self, BUTTON_SERVICES)
        self._target = TargetClient(self, self._on_target, self._diagnostics.warn)
        self.create_timer(TARGET_PERIOD_S, self._ask_for_target, clock=steady_clock())
        self._jump = on_jump_back(self, self._clear)
        # The server's thread tells the number of watchers, this node's thread acts on it.
        self._watched = self.create_guard_condition(self._follow_watchers)
        given = os.environ.get(TOKEN_VARIABLE)
        self._server = PageServer(self._board, config.port, given or secrets.token_urlsafe(16),
                                  services.request, self._on_watchers)
        if not given:
            print(self._server.address, flush=True)  # not into the log, which is a topic too

    def _clear(self) -> None:
        self._profiles.clear()
        self._board.clear()

    def _on_profile(self, profile: ThicknessProfile) -> None:
        self._diagnostics.count('profiles')
        if profile.print_id:
            self._board.profile = profile
        else:
            self._board.forget_print()
        self._server.notify()

    def _on_advice(self, message: RateAdvice) -> None:
        with self._showing():
            advice = advice_from_message(message)
            if advice.print_id:
                self._board.advise(advice)
            else:  # the print was cleared
                self._profiles.clear()
                self._board.forget_print()

    def _on_verdict(self, message: PrintVerdict) -> None:
        with self._showing():
            verdict = verdict_from_message(message)
            self._board.verdict = verdict if verdict.print_id else None

    def _on_design(self, message: DesignComparison) -> None:
        with self._showing():
            self._board.design = design_from_message(message) if message.print_id else None

    def _on_overlay(self, message: Image) -> None:
        with self._showing():
            image = image_to_rgb(message)
            self._board.overlay = (overlay_of(stamp_to_ns(message.header.stamp), image)
                                   if image.size > NO_VIEW_BYTES else None)

    @contextmanager
    def _showing(self) -> Iterator[None]:
        """Tell the server that the block put something on the board; refuse what is unusable."""
        try:
            yield
        except ConversionError as error:
            self._diagnostics.refuse(error)
        except cv2.error as error:  # the shape does not allow a JPEG
            self._diagnostics.refuse(f'overlay: expected an image to show, found: {error}'
                                     '; is its sender bpc?')
        else:
            self._server.notify()

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == self.get_name():
                continue  # a person who sees the page knows that it runs
            level = Level(min(ord(status.level), Level.STALE))
            self._board.hear(status.name, level, status.message)

    def _on_watchers(self, count: int) -> None:
        self._watchers = count
        self._watched.trigger()

    def _follow_watchers(self) -> None:
        self._diagnostics.note('browsers', self._watchers)
        if self._watchers and self._overlay is None:
            self._overlay = self.create_subscription(Image, topics.OVERLAY, self._on_overlay,
                                                     topics.VIEW_QOS)
            self._ask_for_target()
        elif not self._watchers and self._overlay is not None:
            self.destroy_subscription(self._overlay)
            self._overlay = None
        self._profiles.pause(not self._watchers)

    def _ask_for_target(self) -> None:
        if self._watchers:
            self._target.ask()

    def _on_target(self, target: TargetBand | None) -> None:
        self._board.target = target
        self._server.notify()

    def destroy_node(self) -> None:
        """End the server as well."""
        self._server.close()
        super().destroy_node()


def main() -> None:
    """Run the node."""
    run(PageNode, large_messages=True)


if __name__ == '__main__':
    main()
