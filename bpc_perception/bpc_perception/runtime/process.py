"""Ask the operating system for memory, cores, and an end in time of a node's process."""

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

# Set for a child that must not outlive its parent; the value is the process id of the parent.
PARENT_VARIABLE = 'BPC_PARENT'
# Set for a child whose parent wants signs of life; the value is the descriptor of a pipe.
HEARTBEAT_VARIABLE = 'BPC_HEARTBEAT'
HEARTBEAT_PERIOD_S = 0.05

# Options of mallopt (malloc.h of glibc) and their values. A cloud has 37 MB. The largest size that
# glibc keeps for re-use by itself is 32 MB. So each copy would be in new memory, which the kernel
# zeroes page by page, and that takes longer than the copy.
M_TRIM_THRESHOLD, M_TOP_PAD, M_MMAP_MAX, M_ARENA_MAX = -1, -2, -4, -8
ALLOCATOR_OPTIONS = {M_MMAP_MAX: 0, M_TRIM_THRESHOLD: 2**31 - 1, M_TOP_PAD: 64 << 20,
                     M_ARENA_MAX: 1}
ORPHAN_PATIENCE_S = 3.0  # for its own end, after that of its parent
FILES_PATIENCE_S = 30.0  # the same for one that completes files, on a busy machine
ORPHAN_CHECK_PERIOD_S = 0.5
PR_SET_PDEATHSIG = 1  # linux/prctl.h

_parent: int | None = None  # the process with which this one ends


def keep_memory() -> None:
    """Let the allocator keep the memory of a capture for the next one; glibc only.

    Call it before anything else allocates much or starts threads.
    """
    mallopt = getattr(ctypes.CDLL(None), 'mallopt', None)
    if mallopt is not None:
        for option, value in ALLOCATOR_OPTIONS.items():
            mallopt(option, value)


def end_with_parent(patience: float = ORPHAN_PATIENCE_S) -> bool:
    """End when the parent process ends, even by SIGKILL, ``patience`` [s] later; Linux only.

    Return whether the parent wants that.
    """
    parent = os.environ.pop(PARENT_VARIABLE, '')
    prctl = getattr(ctypes.CDLL(None), 'prctl', None)
    if not parent or prctl is None:
        return False
    global _parent
    _parent = int(parent)
    prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(parent):  # it ended before
        raise SystemExit(1)
    Thread(target=_end_orphaned, args=(int(parent), patience), daemon=True).start()
    return True


def orphaned() -> bool:
    """Return whether the parent process, with which this one was to end, has ended."""
    return _parent is not None and os.getppid() != _parent


def _end_orphaned(parent: int, patience: float) -> None:
    """Exit at once if SIGTERM was not enough: the middleware may hang in its shutdown."""
    while os.getppid() == parent:
        time.sleep(ORPHAN_CHECK_PERIOD_S)
    time.sleep(patience)
    os._exit(1)


def open_heartbeat() -> int | None:
    """Return the pipe into which the parent wants signs of life; None = it wants none."""
    value = os.environ.pop(HEARTBEAT_VARIABLE, '')
    if not value:
        return None
    pipe = int(value)
    os.set_inheritable(pipe, False)
    os.set_blocking(pipe, False)
    return pipe


class Heartbeat:
    """Signs of life of a node, given between callbacks: a node that hangs in one gives none."""

    def __init__(self, pipe: int | None, name: str) -> None:
        self._pipe = pipe
        self._sign = f'{name}\n'.encode()
        self._next = 0.0

    def beat(self) -> None:
        """Give a sign of life, unless the last one is less than HEARTBEAT_PERIOD_S ago."""
        if self._pipe is None or time.monotonic() < self._next:
            return
        self._next = time.monotonic() + HEARTBEAT_PERIOD_S
        with suppress(OSError):  # the parent does not read just now, or any more
            os.write(self._pipe, self._sign)


def limit_cpu_use(config: ProcessConfig, logger: RcutilsLogger) -> None:
    """Limit the threads of OpenCV and lower the priority as the configuration says."""
    cv2.setNumThreads(config.threads)
    if config.niceness == 0:
        return
    try:
        # Linux has a niceness for each thread, and those of the middleware run by now.
        for thread in Path('/proc/self/task').iterdir():
            os.setpriority(os.PRIO_PROCESS, int(thread.name), config.niceness)
    except OSError as error:
        logger.warning(f'process.niceness: expected to be allowed {config.niceness}, found: '
                       f'{error}; running with {os.getpriority(os.PRIO_PROCESS, 0)}')
