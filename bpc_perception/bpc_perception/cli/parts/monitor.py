"""Follows profiles and advice of running nodes."""

from __future__ import annotations

import atexit
from collections.abc import Callable, Iterator
from contextlib import contextmanager
import signal
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rich.console import RenderableType

from bpc_interfaces.msg import (
    DesignComparison,
    PrintVerdict as PrintVerdictMsg,
    RateAdvice as RateAdviceMsg,
    RepairPlan as RepairPlanMsg,
)
from bpc_perception.claims import domain
from bpc_perception.cli.parts.live_view import view
from bpc_perception.cli.parts.patient_output import patient_output
from bpc_perception.cli.parts.recent_warnings import RecentWarnings
from bpc_perception.cli.parts.result_table import ResultTable
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.design.comparison import DesignFindings
from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.repair.plan import RepairPlan
from bpc_perception.display.plain_text import one_line
from bpc_perception.messages import topics
from bpc_perception.messages.results.advice import advice_from_message
from bpc_perception.messages.results.design import design_from_message
from bpc_perception.messages.results.repair import repair_from_message
from bpc_perception.messages.results.verdict import verdict_from_message
from bpc_perception.messages.stamps import ConversionError
from bpc_perception.nodes.parts.profile_follower import ProfileFollower
from bpc_perception.runtime.signals import end_in_time, ending_signals
from bpc_perception.runtime.transport.dds_profiles import receive_profile
from bpc_perception.runtime.transport.middleware import expect_middleware

# What the node logs is shown by the terminal, and needs no file.
ROS_ARGUMENTS = ['--ros-args', '--disable-external-lib-logs']
DISCOVERY_S = 0.6  # in which publishers of other processes are discovered, with a margin
SPIN_PERIOD_S = 0.05


class Monitor:
    """Collects what the thickness node publishes and prints a line for each capture.

    A message that cannot be used, from whatever node, is shown like a warning in the diagnostics.

    Attributes:
        node: that listens.
        profiles, advice, verdicts, repairs: by stamp of the capture, in order of arrival; the
            newest ``keep``, or all of them.
        print_ids: of the prints that were measured, in order.
        checks: called again and again while messages are handled; an error ends it all.
    """

    def __init__(self, node: Node, executor: SingleThreadedExecutor, terminal: Terminal,
                 keep: int | None = None) -> None:
        self.node = node
        self.profiles: dict[int, ThicknessProfile] = {}
        self.advice: dict[int, RateAdvice] = {}
        self.verdicts: dict[int, PrintVerdict] = {}
        self.repairs: dict[int, RepairPlan] = {}
        self._designs: dict[str, DesignFindings] = {}  # by print, the newest
        self._keep = keep
        self._executor = executor
        self._terminal = terminal
        self._table = ResultTable(terminal)
        self._shown: tuple[int, float] | None = None  # stamp, when it came by a steady clock [s]
        self._warnings = RecentWarnings()
        self.print_ids: list[str] = []
        self.checks: list[Callable[[], None]] = []
        self._interrupted = False
        ProfileFollower(node, self._on_profile, self._refuse)
        node.create_subscription(RateAdviceMsg, topics.ADVICE, self._on_advice, topics.RESULT_QOS)
        node.create_subscription(
            PrintVerdictMsg, topics.VERDICT, self._on_verdict, topics.RESULT_QOS)
        node.create_subscription(
            DesignComparison, topics.DESIGN, self._on_design, topics.RESULT_QOS)
        node.create_subscription(
            RepairPlanMsg, topics.REPAIR, self._on_repair, topics.RESULT_QOS)
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)

    @property
    def warnings(self) -> list[str]:
        """The warnings in the diagnostics and our own, the last of each kind."""
        return self._warnings.texts

    def interrupt(self, *_: object) -> None:
        """End spinning with KeyboardInterrupt, now or when it begins."""
        self._interrupted = True

    def spin_until(self, done: Callable[[], bool], timeout: float | None = None,
                   check: Callable[[], None] | None = None) -> bool:
        """Handle messages until something is done.

        Args:
            done: whether it is.
            timeout: after which to give up [s]; None = never.
            check: raises an error to end it all; called again and again.

        Returns:
            Whether it was done in time.

        Raises:
            KeyboardInterrupt: after ``interrupt``.
        """
        end = None if timeout is None else time.monotonic() + timeout
        while True:
            for each in (*self.checks, *([check] if check is not None else [])):
                each()
            if done():
                return True
            if self._interrupted:
                raise KeyboardInterrupt
            if end is not None and time.monotonic() > end:
                return False
            self._executor.spin_once(timeout_sec=SPIN_PERIOD_S)
            if self._shown is not None:
                self._terminal.draw(self._view)

    def publishers(self, name: str) -> int:
        """Return how many publish a topic."""
        return int(self.node.count_publishers(name))

    def subscribers(self, name: str) -> int:
        """Return how many listen to a topic."""
        return int(self.node.count_subscribers(name))

    def expect_no_other_printer(self) -> None:
        """Raise ValueError if a printer publishes already: its poses would mix with ours."""
        self.spin_until(lambda: False, DISCOVERY_S)
        for name in (topics.EXTRUSION, *topics.POSES, *topics.CAMERA):
            count = self.publishers(name)
            if count:
                raise ValueError(f'{name}: expected no publisher before the start, found {count}; '
                                 'set ROS_DOMAIN_ID to a number of its own')

    def sees(self, *names: str) -> bool:
        """Return whether nodes of all these names are there."""
        return set(names) <= set(self.node.get_node_names())

    def hears_results(self) -> bool:
        """Return whether all results have a publisher.

        A node is known by name before its publishers are: its first result would be missed.
        """
        return all(self.publishers(name)
                   for name in (topics.PROFILE, topics.ADVICE, topics.VERDICT, topics.REPAIR))

    def has(self, stamp_ns: int) -> bool:
        """Return whether all results of a capture have come."""
        return all(stamp_ns in each for each in (self.profiles, *self._others))

    @property
    def _others(self) -> tuple[dict[int, Any], ...]:
        """What comes beside each profile."""
        return self.advice, self.verdicts, self.repairs

    def last_verdicts(self) -> list[PrintVerdict]:
        """Return the newest verdict on each print, of those that are kept."""
        return list({each.print_id: each for each in self.verdicts.values()}.values())

    def design_of(self, print_id: str) -> DesignFindings | None:
        """Return what is known last of a print beside its design; None = there is none."""
        return self._designs.get(print_id)

    def _on_profile(self, profile: ThicknessProfile) -> None:
        if not profile.print_id:
            self._shown = None
            self._terminal.emit('cleared', 'The print was cleared: its advice holds no longer.')
            return
        if profile.stamp_ns in self.profiles:  # a recording loops: what else came is of before
            for others in self._others:
                others.pop(profile.stamp_ns, None)
        self.profiles[profile.stamp_ns] = profile
        if profile.print_id not in self.print_ids:
            self.print_ids.append(profile.print_id)
        self._show(profile.stamp_ns)
        if self._keep is not None:
            for stamp_ns in list(self.profiles)[:-self._keep]:
                for kept in (self.profiles, *self._others):
                    kept.pop(stamp_ns, None)

    def _on_advice(self, message: RateAdviceMsg) -> None:
        try:
            advice = advice_from_message(message)
        except ConversionError as error:
            self._refuse(error)
            return
        if not advice.print_id:
            return
        self.advice[advice.stamp_ns] = advice
        self._show(advice.stamp_ns)

    def _on_verdict(self, message: PrintVerdictMsg) -> None:
        try:
            verdict = verdict_from_message(message)
        except ConversionError as error:
            self._refuse(error)
            return
        if not verdict.print_id:
            return
        self.verdicts[verdict.stamp_ns] = verdict
        self._show(verdict.stamp_ns)

    def _on_design(self, message: DesignComparison) -> None:
        try:
            design = design_from_message(message)
        except ConversionError as error:
            self._refuse(error)
            return
        if message.print_id:
            self._designs[message.print_id] = design

    def _on_repair(self, message: RepairPlanMsg) -> None:
        try:
            plan = repair_from_message(message)
        except ConversionError as error:
            self._refuse(error)
            return
        if not plan.print_id:
            return
        again = plan.stamp_ns in self.repairs  # the print ended
        self.repairs[plan.stamp_ns] = plan
        if not again:
            self._show(plan.stamp_ns)

    def _refuse(self, error: ConversionError) -> None:
        self._warn(f'{self.node.get_name()}: {error}')

    def _show(self, stamp_ns: int) -> None:
        """Show a capture if all its results have come."""
        if self.has(stamp_ns):
            self._table.add_profile(self.profiles[stamp_ns], self.advice[stamp_ns],
                                    self.verdicts[stamp_ns])
            self._shown = stamp_ns, time.monotonic()

    def _view(self) -> RenderableType:
        assert self._shown is not None
        stamp_ns, arrived = self._shown
        if not self.has(stamp_ns):
            return ''  # results of the next capture are under way
        return view(self.profiles[stamp_ns], self.advice[stamp_ns], self.verdicts[stamp_ns],
                    self._terminal.width, time.monotonic() - arrived)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            # A stale node has not begun yet, or is busy.
            if status.level in (DiagnosticStatus.WARN, DiagnosticStatus.ERROR):
                self._warn(f'{status.name}: {status.message}')

    def _warn(self, text: str) -> None:
        if self._warnings.add(text):
            self._terminal.emit('diagnostic', f'  {one_line(text)}', text=text)


@contextmanager
def monitoring(terminal: Terminal, keep: int | None = None) -> Iterator[Monitor]:
    """Run a monitor in this process's ROS graph; an ending signal ends the block quietly.

    It keeps the newest ``keep`` results, or all of them. Raises HeldError if another suite has
    the ROS domain.
    """
    expect_middleware()
    with patient_output(), domain.claimed(terminal.say):
        yield from _monitoring(terminal, keep)


def _monitoring(terminal: Terminal, keep: int | None) -> Iterator[Monitor]:
    # The handlers only take note. Those of rclpy shut down under a running callback; those of
    # Python raise in the middle of a message, which comes out of rclpy like any other error.
    early: list[int] = []
    before = {number: signal.signal(number, lambda received, _: early.append(received))
              for number in ending_signals()}
    atexit.register(end_in_time)
    rclpy.init(args=ROS_ARGUMENTS, signal_handler_options=SignalHandlerOptions.NO)
    with receive_profile(large_messages=False):
        node = rclpy.create_node('bpc_monitor')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    monitor = Monitor(node, executor, terminal, keep)
    for number in before:
        signal.signal(number, monitor.interrupt)
    if early:
        monitor.interrupt()
    try:
        with terminal.view():
            yield monitor
    except KeyboardInterrupt:
        pass
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        node.destroy_node()
        rclpy.try_shutdown()
