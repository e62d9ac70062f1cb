"""Run the command line: ``bpc``, or ``python -m bpc_perception``."""

from io import TextIOWrapper
import os
import sys

from bpc_perception.runtime.exit_status import INTERRUPTED
from bpc_perception.runtime.signals import exit_on_signal
from bpc_perception.runtime.transport.middleware import do_without_missing


def main() -> None:
    """Load the command line, which takes a second, and run it."""
    open_standard_streams()
    try:
        if isinstance(sys.stdout, TextIOWrapper):
            sys.stdout.reconfigure(errors='replace')  # where a terminal has no "±"
        do_without_missing()
        with exit_on_signal():
            from bpc_perception.cli.app import main as run_command
        run_command()
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)


def open_standard_streams() -> None:
    """Open those that the caller has closed; what is opened next would be taken for them."""
    for handle in range(3):
        try:
            os.fstat(handle)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest number that is free
    sys.stdout = sys.stdout or open(os.devnull, 'w')  # noqa: SIM115 (until the end)
    sys.stderr = sys.stderr or open(os.devnull, 'w')  # noqa: SIM115


if __name__ == '__main__':
    main()
