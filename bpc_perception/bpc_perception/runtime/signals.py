"""How a process is asked to end, and that it does."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import os
import signal
import sys

from bpc_perception.runtime.exit_status import INTERRUPTED

ENDING = 5  # an end may take so long, on a busy machine too [s]


def ending_signals() -> tuple[signal.Signals, ...]:
    """Ctrl-C, SIGTERM, and SIGHUP of a terminal that is closed, unless nohup lets it be ignored.

    To be asked before handlers are set: who ignores it is told from what is set.
    """
    ignored = signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    return (signal.SIGINT, signal.SIGTERM, *(() if ignored else (signal.SIGHUP,)))


@contextmanager
def exit_on_signal() -> Iterator[None]:
    """While the block imports, ending signals just end the process; then they interrupt it.

    An exception might be swallowed by what is just being imported. Shells let what they start in
    the background ignore SIGINT; who sends it all the same means it.
    """
    numbers = ending_signals()
    for number in numbers:
        signal.signal(number, lambda *_: os._exit(INTERRUPTED))
    yield
    for number in numbers:
        signal.signal(number, signal.default_int_handler)


def end_in_time() -> None:
    """Let the kernel end this process should its ending hang, once all that it has said is out.

    No thread of Python could, where it hangs in C++ that holds the interpreter's lock.
    """
    with suppress(OSError, ValueError):  # nobody reads it any more
        sys.stdout.flush()
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(ENDING)
