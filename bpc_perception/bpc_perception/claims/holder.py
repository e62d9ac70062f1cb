"""Say in words which process holds something."""

from __future__ import annotations

from contextlib import suppress
from datetime import datetime
import os
from pathlib import Path
import time

LONGEST_COMMAND = 120  # letters


class HeldError(ValueError):
    """Another process has what was claimed; the message says which, and what to do."""


def is_alive(pid: int) -> bool:
    """Return whether a process exists, and has not just ended."""
    return bool(pid) and _state(pid)[:1] not in ([], ['Z'], ['X'])


def described(pid: int) -> str:
    """Return a process in words: its id, command, start and folder, as far as we may know them."""
    state = _state(pid) if pid else []
    if not state:
        return 'a process that cannot be seen from here'
    words = [f'process {pid}']
    if command := _command(pid):
        words.append(f'({command})')
    ticks = float(state[19]) / os.sysconf('SC_CLK_TCK')  # since the computer was started
    began = time.time() - time.clock_gettime(time.CLOCK_BOOTTIME) + ticks
    words.append(f'since {datetime.fromtimestamp(began):%Y-%m-%d %H:%M:%S}')
    with suppress(OSError):  # it belongs to somebody else
        words.append(f'in {os.readlink(f"/proc/{pid}/cwd")}')
    return ' '.join(words)


def _state(pid: int) -> list[str]:
    """Return what follows the name in ``/proc/PID/stat`` [man 5 proc]; empty = it has ended."""
    try:
        return Path(f'/proc/{pid}/stat').read_text(errors='replace').rpartition(')')[2].split()
    except OSError:
        return []


def _command(pid: int) -> str:
    """Return the command of a process, without the Python that runs it and settings of ROS."""
    try:
        words = Path(f'/proc/{pid}/cmdline').read_bytes().decode(errors='replace').split('\0')
    except OSError:
        return ''
    if '-m' in words[:3]:
        words = words[words.index('-m') + 1:]
    words[:1] = [words[0].replace('bpc_perception.nodes.', '').replace('bpc_perception', 'bpc')]
    if '--ros-args' in words:
        words = words[:words.index('--ros-args')]
    text = ' '.join(words).strip()
    return text if len(text) <= LONGEST_COMMAND else f'{text[:LONGEST_COMMAND]}…'
