"""Runs a command that ends, with all its children, when whoever started it ends.

It waits for the end of its standard input. That comes however the other process ends, even by
SIGKILL. The guard leads a process group of its own, so that it outlives its parent for this. What
it runs steps back behind a print that is measured meanwhile.
"""

import os
import signal
import subprocess
import sys
from threading import Thread


def end_with_parent() -> None:
    """Kill the command, its children and this process once the standard input ends."""
    os.read(0, 1)
    os.killpg(0, signal.SIGKILL)


NICENESS = 5

if __name__ == '__main__':
    os.nice(NICENESS)
    Thread(target=end_with_parent, daemon=True).start()
    sys.exit(subprocess.call(sys.argv[1:], stdin=subprocess.DEVNULL))
