"""Memory and processor time of a process."""

from __future__ import annotations

import os
from pathlib import Path


def memory_mb(process: int) -> float:
    """Return the resident memory of a process [MB]."""
    pages = int(Path(f'/proc/{process}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 1e6


def cpu_time(process: int) -> float:
    """Return the time of all cores that a process has used so far [s]."""
    # Fields 14 and 15 of proc(5); the second field, in parentheses, may hold spaces.
    fields = Path(f'/proc/{process}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')
