"""The descendants of processes, and whether they are alive."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def descendants(pids: Iterable[int]) -> list[int]:
    """Return all processes that these started, directly or not."""
    found = []
    for pid in pids:
        for children in Path(f'/proc/{pid}/task').glob('*/children'):
            try:
                started = [int(child) for child in children.read_text().split()]
            except OSError:
                continue
            found += started + descendants(started)
    return found


def alive(pid: int) -> bool:
    """Tell whether a process exists and is no zombie."""
    try:
        return Path(f'/proc/{pid}/stat').read_text().rsplit(')', 1)[1].split()[0] != 'Z'
    except OSError:
        return False
