"""Starting a node and ending it in good order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import logging
import signal
import sys
from threading import Thread
import traceback

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from bpc_perception.nodes.process import (
    end_in_time,
    end_with_parent,
    Heartbeat,
    keep_memory,
    open_heartbeat,
)

try:
    from rclpy.experimental import EventsExecutor
except ImportError:  # before rclpy 7.1.4
    EventsExecutor = None  # type: ignore[assignment]

REFUSED = 2  # exit status: what was asked for cannot be done as it was asked


class RosLogHandler(logging.Handler):
    """Hands the core's log records to the node's logger."""

    def __init__(self, node: Node) -> None:
        super().__init__()
        self._logger = node.get_logger()

    def emit(self, record: logging.LogRecord) -> None:
        """Log at the same level."""
        level = {logging.WARNING: 'warning', logging.ERROR: 'error'}.get(record.levelno, 'info')
        getattr(self._logger, level)(record.getMessage())


def run(make_node: Callable[[], Node | Sequence[Node]], carries_captures: bool = False,
        fast_streams: bool = False) -> None:
    """Spin a node until Ctrl-C, SIGTERM or shutdown; exit with 2 if it refuses to start.

    Of several nodes each has a thread of its own, so that none waits for another's callbacks.

    Args:
        make_node: makes the node or nodes.
        carries_captures: messages of 40 MB come or go.
        fast_streams: hundreds of messages come a second; half the work where rclpy can do it.
    """
    if carries_captures:
        keep_memory()
    is_child = end_with_parent()
    pipe = open_heartbeat()
    # At a signal rclpy ends the spinning. Python would raise KeyboardInterrupt besides, in the
    # middle of anything, and the process aborts where that is C++ which takes no exceptions.
    told: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, _: told.append(number))
    rclpy.init()
    try:
        if not told:  # before rclpy listened to it
            _spin(make_node, fast_streams, pipe, is_child)
    except ExternalShutdownException:
        pass
    finally:
        if is_child:
            end_in_time()
        rclpy.try_shutdown()
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a second one, while Python winds up


def _spin(make_node: Callable[[], Node | Sequence[Node]], fast_streams: bool,
          pipe: int | None, is_child: bool) -> None:
    try:
        made = make_node()
    except (ValueError, OSError, ParameterException) as error:
        print(f'{make_node.__name__}: {error}', file=sys.stderr)
        sys.exit(REFUSED)
    except Exception:  # half-made nodes raise all sorts of things when told to end meanwhile
        if rclpy.ok():
            raise
        return
    nodes = [made] if isinstance(made, Node) else list(made)
    logging.getLogger('bpc_perception').addHandler(RosLogHandler(nodes[0]))
    failures: list[Exception] = []
    aside = [Thread(target=_spin_one, args=(node, failures, pipe)) for node in nodes[1:]]
    for thread in aside:
        thread.start()
    try:
        _spin_one(nodes[0], failures, pipe, fast_streams)
    finally:
        if is_child:
            end_in_time()
        for thread in aside:
            thread.join()
        for node in nodes:
            node.destroy_node()
        if failures:
            traceback.print_exception(failures[0])
            sys.exit(1)


def _spin_one(node: Node, failures: list[Exception], pipe: int | None,
              fast: bool = False) -> None:
    """Spin in a thread; all end when this one does."""
    # Not the multi-threaded executor: on Jazzy it loses most of a fast stream (rclpy #1452).
    kind = EventsExecutor if fast and EventsExecutor is not None else SingleThreadedExecutor
    heart = Heartbeat(pipe, node.get_name())
    if not rclpy.ok():  # told to end while the node was made
        return
    try:
        executor = kind()
        executor.add_node(node)
        # Not spin(): that of the events executor never sleeps.
        while rclpy.ok():
            executor.spin_once(timeout_sec=0.1)
            heart.beat()
    except ExternalShutdownException:
        pass
    except Exception as error:
        if rclpy.ok():  # or else it was told to end in the middle of something
            failures.append(error)
    finally:
        rclpy.try_shutdown()
