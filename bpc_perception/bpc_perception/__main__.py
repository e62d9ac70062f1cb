"""Runs the command line as ``python -m bpc_perception``."""

from collections.abc import Callable
import os
import signal
import sys

from bpc_perception.exit_status import INTERRUPTED


def load() -> Callable[[], None]:
    """The command line, whose loading takes a second, in which Ctrl-C just ends the process.

    An exception instead might be swallowed by what is just being imported.
    """
    before = signal.signal(signal.SIGINT, lambda *_: os._exit(INTERRUPTED))
    from bpc_perception.cli import main

    signal.signal(signal.SIGINT, before)
    return main


if __name__ == '__main__':
    main = load()
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
