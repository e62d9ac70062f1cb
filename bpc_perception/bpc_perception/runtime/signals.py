"""The signals that end a process, and how it ends in time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import os
import signal
import sys

from bpc_perception.runtime.exit_status import INTERRUPTED

LONGEST_END_S = 5  # on a busy machine, too


def ending_signals() -> tuple[signal.Signals, ...]:
    """Return the signals that end us: of Ctrl-C, SIGTERM, and SIGHUP of a closed terminal.

    SIGHUP is left out when it is ignored, as by nohup. Call this before handlers are set: they
    replace the mark that it is ignored.
    """
    ignored = signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    return (signal.SIGINT, signal.SIGTERM, *(() if ignored else (signal.SIGHUP,)))


@contextmanager
def exit_on_signal() -> Iterator[None]:
    """Let ending signals exit at once during the block, and raise KeyboardInterrupt after it.

    The block imports, and a module that is being imported might swallow an exception. A shell lets
    its background processes ignore SIGINT; if someone sends it nevertheless, it is meant.
    """
    numbers = ending_signals()
    for number in numbers:
        signal.signal(number, lambda *_: os._exit(INTERRUPTED))
    yield
    for number in numbers:
        signal.signal(number, signal.default_int_handler)


def end_in_time() -> None:
    """Flush the output, and let the kernel end this process if its end hangs.

    That is for whoever is in a ROS graph: the middleware may wait for ever. No Python thread could
    end a process that hangs in C++ with the interpreter's lock. All others end by themselves,
    however long that takes on a busy machine.
    """
    with suppress(OSError, ValueError):  # nobody reads the output any more
        sys.stdout.flush()
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(LONGEST_END_S)
