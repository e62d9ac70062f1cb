"""What a node's process asks of the operating system: memory, cores, and an end in good time."""

from __future__ import annotations

from contextlib import suppress
import ctypes
import os
from pathlib import Path
import signal
from threading import Thread
import time

import cv2
from rclpy.impl.rcutils_logger import RcutilsLogger

from bpc_perception.core.config import ProcessConfig

# Set for a child that shall not outlive its parent; its value is the parent's process id.
PARENT_VARIABLE = 'BPC_PARENT'
# Set for a child whose parent wants signs of life; its value is the descriptor of a pipe.
HEARTBEAT_VARIABLE = 'BPC_HEARTBEAT'
HEARTBEAT_PERIOD = 0.05  # [s]

# Options of mallopt (malloc.h of glibc) and their values. A cloud of 37 MB exceeds the largest
# size that glibc keeps for re-use by itself, 32 MB: each copy would be new memory, which the
# kernel zeroes page by page, for longer than the copy takes.
M_TRIM_THRESHOLD, M_TOP_PAD, M_MMAP_MAX, M_ARENA_MAX = -1, -2, -4, -8
ALLOCATOR = {M_MMAP_MAX: 0, M_TRIM_THRESHOLD: 2**31 - 1, M_TOP_PAD: 64 << 20, M_ARENA_MAX: 1}
ORPHAN_PATIENCE = 3.0  # [s]
PR_SET_PDEATHSIG = 1  # linux/prctl.h


def keep_memory() -> None:
    """Let the allocator keep what was used for a capture for the next one; glibc only.

    To be called before anything else allocates much, or starts threads.
    """
    mallopt = getattr(ctypes.CDLL(None), 'mallopt', None)
    if mallopt is not None:
        for option, value in ALLOCATOR.items():
            mallopt(option, value)


def end_with_parent() -> bool:
    """End when the process that started this one ends, even by SIGKILL; Linux only.

    Whether there is one that wants that.
    """
    parent = os.environ.pop(PARENT_VARIABLE, '')
    prctl = getattr(ctypes.CDLL(None), 'prctl', None)
    if not parent or prctl is None:
        return False
    prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(parent):  # it ended before
        raise SystemExit(1)
    Thread(target=_end_orphaned, args=(int(parent),), daemon=True).start()
    return True


def _end_orphaned(parent: int) -> None:
    """End the hard way where SIGTERM was not enough: the middleware may hang in its shutdown."""
    while os.getppid() == parent:
        time.sleep(0.5)
    time.sleep(ORPHAN_PATIENCE)
    os._exit(1)


def open_heartbeat() -> int | None:
    """The pipe into which the parent wants signs of life; None = it wants none."""
    value = os.environ.pop(HEARTBEAT_VARIABLE, '')
    if not value:
        return None
    pipe = int(value)
    os.set_inheritable(pipe, False)
    os.set_blocking(pipe, False)
    return pipe


class Heartbeat:
    """Signs of life of a node, given between its callbacks: who hangs in one gives none."""

    def __init__(self, pipe: int | None, name: str) -> None:
        self._pipe = pipe
        self._sign = f'{name}\n'.encode()
        self._next = 0.0

    def beat(self) -> None:
        """Give a sign of life, unless there was one a moment ago."""
        if self._pipe is None or time.monotonic() < self._next:
            return
        self._next = time.monotonic() + HEARTBEAT_PERIOD
        with suppress(OSError):  # nobody reads it just now, or any more
            os.write(self._pipe, self._sign)


def limit_cpu_use(config: ProcessConfig, logger: RcutilsLogger) -> None:
    """Bound the threads of OpenCV and give way to others as the configuration says."""
    cv2.setNumThreads(config.threads)
    if config.niceness == 0:
        return
    try:
        # Linux keeps a niceness for each thread, and the middleware's have started by now.
        for thread in Path('/proc/self/task').iterdir():
            os.setpriority(os.PRIO_PROCESS, int(thread.name), config.niceness)
    except OSError as error:
        logger.warning(f'process.niceness: expected to be allowed {config.niceness}, found: '
                       f'{error}; running with {os.getpriority(os.PRIO_PROCESS, 0)}')
