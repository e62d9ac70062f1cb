"""Run the command line: ``bpc``, or ``python -m bpc_perception``."""

from io import TextIOWrapper
import sys

from bpc_perception.runtime.exit_status import INTERRUPTED
from bpc_perception.runtime.signals import exit_on_signal
from bpc_perception.runtime.transport.middleware import do_without_missing


def main() -> None:
    """Load the command line, which takes a second, and run it."""
    try:
        if isinstance(sys.stdout, TextIOWrapper):
            sys.stdout.reconfigure(errors='replace')  # where a terminal has no "±"
        do_without_missing()
        with exit_on_signal():
            from bpc_perception.cli.app import main as run_command
        run_command()
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)


if __name__ == '__main__':
    main()
