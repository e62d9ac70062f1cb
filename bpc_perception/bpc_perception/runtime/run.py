"""Start a node and end it in good order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
import gc
import logging
import signal
import sys
from threading import Thread
import traceback
from typing import Any

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from bpc_perception.display.plain_text import one_line, printable
from bpc_perception.runtime.exit_status import DEFECT, REFUSED
from bpc_perception.runtime.process import (
    end_with_parent,
    FILES_PATIENCE_S,
    Heartbeat,
    keep_memory,
    open_heartbeat,
    ORPHAN_PATIENCE_S,
    orphaned,
)
from bpc_perception.runtime.signals import end_in_time, ending_signals
from bpc_perception.runtime.transport.dds_profiles import receive_profile
from bpc_perception.runtime.transport.middleware import expect_middleware

try:
    from rclpy.experimental import EventsExecutor
except ImportError:  # before rclpy 7.1.4
    EventsExecutor = None  # type: ignore[assignment]


class RosLogHandler(logging.Handler):
    """Hands the log records of the core to the logger of a node."""

    def __init__(self, node: Node) -> None:
        super().__init__()
        self._logger = node.get_logger()

    def emit(self, record: logging.LogRecord) -> None:
        """Log a record at its level."""
        level = {logging.WARNING: 'warning', logging.ERROR: 'error'}.get(record.levelno, 'info')
        getattr(self._logger, level)(printable(record.getMessage()))


class _Ending:
    """Whether all nodes of the process have to end."""

    def __init__(self) -> None:
        self.asked = False

    def ask(self, *_: object) -> None:
        """Let them end; also serves as a handler of signals."""
        self.asked = True


def run(make_node: Callable[[], Node | Sequence[Node]], large_messages: bool = False,
        fast_streams: bool = False, on_purpose: Callable[[Any], None] | None = None,
        complete: Callable[[Any], None] | None = None) -> None:
    """Spin a node until an ending signal; exit with 2 if it refuses to start.

    Several nodes have a thread each, so that none waits for the callbacks of another.

    Args:
        make_node: makes the node or nodes.
        large_messages: the nodes take or send captures or views, messages of up to 40 MB.
        fast_streams: the nodes take hundreds of messages a second. With a recent rclpy that costs
            half the work.
        on_purpose: called with each node when someone ends it, unlike when it, or the process that
            started it, has crashed.
        complete: called with each node at its end to complete its files, unless it has crashed
            itself; may take FILES_PATIENCE_S.
    """
    try:
        expect_middleware()
    except ValueError as error:
        raise _refusal(make_node, str(error)) from None
    if large_messages:
        keep_memory()
    is_child = end_with_parent(ORPHAN_PATIENCE_S if complete is None else FILES_PATIENCE_S)
    pipe = open_heartbeat()
    # A signal is only noted, and looked at between callbacks. A KeyboardInterrupt aborts the
    # process when it comes out of C++ that takes no exceptions. The handlers of rclpy shut down
    # under a half-made node, which then stays in the graphs of others.
    ending = _Ending()
    numbers = ending_signals()
    for number in numbers:
        signal.signal(number, ending.ask)
    _begin(make_node)
    nodes: list[Node] = []
    failures: list[Exception] = []
    try:
        if not ending.asked:
            nodes += _make(make_node, large_messages)
            _spin(nodes, ending, failures, pipe, fast_streams)
        if on_purpose is not None and not failures and not orphaned():
            for node in nodes:
                on_purpose(node)
        if complete is not None and not failures:
            for node in nodes:
                complete(node)
    finally:
        if is_child:  # others, such as a recorder, may take as long as their files need
            end_in_time()
        for node in nodes:
            node.destroy_node()
        end_in_time()
        rclpy.try_shutdown()
        # More signals may come. Python restores their default action at its end, which would
        # kill the process.
        for number in numbers:
            signal.signal(number, signal.SIG_IGN)
    if failures:
        traceback.print_exception(failures[0])
        sys.exit(DEFECT)


def _begin(make_node: Callable[[], object]) -> None:
    """Begin with ROS; exit with REFUSED and the reason if its arguments cannot be read."""
    try:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:  # as of a parameter file, with its line
        raise _refusal(make_node, 'expected ROS arguments that can be read, found: '
                       f'{error}; correct them, or the file that is named') from None


def _make(make_node: Callable[[], Node | Sequence[Node]], large_messages: bool) -> list[Node]:
    """Make the nodes; exit with REFUSED and the reason if they refuse to start."""
    try:
        with receive_profile(large_messages):
            made = make_node()
        return [made] if isinstance(made, Node) else list(made)
    except (ValueError, OSError, ParameterException) as error:
        reason = str(error)  # the error itself would keep half-made nodes
    raise _refusal(make_node, reason)


def _refusal(make_node: Callable[..., object], reason: str) -> SystemExit:
    """Say why nodes cannot be made; return what ends the process."""
    with suppress(OSError):  # no room for it; the status tells as well
        print(f'{make_node.__name__}: {one_line(reason)}', file=sys.stderr)
    gc.collect()  # half-made nodes then leave the graph
    return SystemExit(REFUSED)


def _spin(nodes: Sequence[Node], ending: _Ending, failures: list[Exception], pipe: int | None,
          fast_streams: bool) -> None:
    logging.getLogger('bpc_perception').addHandler(RosLogHandler(nodes[0]))
    aside = [Thread(target=_spin_one, args=(node, ending, failures, pipe)) for node in nodes[1:]]
    for thread in aside:
        thread.start()
    try:
        _spin_one(nodes[0], ending, failures, pipe, fast_streams)
    finally:
        for thread in aside:
            thread.join()


def _spin_one(node: Node, ending: _Ending, failures: list[Exception], pipe: int | None,
              fast: bool = False) -> None:
    """Spin a node in its thread; let all end when this one does."""
    # Not the multi-threaded executor: on Jazzy it loses most of a fast stream (rclpy #1452).
    kind = EventsExecutor if fast and EventsExecutor is not None else SingleThreadedExecutor
    heart = Heartbeat(pipe, node.get_name())
    try:
        executor = kind()
        executor.add_node(node)
        # Not spin(): with the events executor it never sleeps.
        while not ending.asked:
            heart.beat()  # also before the first callback, which may hang
            executor.spin_once(timeout_sec=0.1)
    except Exception as error:
        failures.append(error)
    finally:
        ending.ask()
