"""Find and remove the shared memory of Fast DDS that killed processes left.

Each participant has a segment ``fastrtps_<16 hexadecimal digits>`` of up to 70 MB. Each port on
which it listens has ``fastrtps_port<number>`` and ``sem.fastrtps_port<number>_mutex``. Segment and
port also have an empty file, ``..._el`` or ``..._sl``, on which the owner holds a lock (flock) as
long as it lives [Fast DDS 2.14, src/cpp/utils/shared_memory and tools/fastdds/shm].

Our own profiles, ``bpc_<random>.xml``, are there while a node is made. They are locked themselves.
"""

from __future__ import annotations

from collections.abc import Container, Iterator
from contextlib import ExitStack, suppress
import fcntl
import os
from pathlib import Path
import re
import time

SHARED_MEMORY = Path('/dev/shm')  # noqa: S108 (where Fast DDS has it)
NAME = re.compile(r'(fastrtps_(?:[0-9a-f]{16}|port\d{1,5})|bpc_\w+\.xml)(_el|_sl)?')
SETTLING_TIME_S = 2.0  # the process of a younger file may not have locked it yet


def clean(folder: Path = SHARED_MEMORY, settled: float = SETTLING_TIME_S,
          among: Container[str] | None = None, leaving: bool = False) -> int:
    """Remove the files that no living process uses; return how many bytes that freed.

    Args:
        folder: where to look.
        settled: files younger than this [s] are left.
        among: if given, only files of these names are removed.
        leaving: this process ends, so what it has mapped itself does not count as used.
    """
    freed = 0
    for file in unused(folder, settled, leaving):
        name = NAME.search(file.name)
        if among is not None and (name is None or name[1] not in among):
            continue
        with suppress(OSError):  # another process removed it first
            size = file.stat().st_size
            file.unlink()
            freed += size
    return freed


def used_by(pid: int) -> set[str]:
    """Return the names of the files that a process has mapped or open; none if it has ended."""
    process, found = Path(f'/proc/{pid}'), []
    with suppress(OSError):
        found.append((process / 'maps').read_text(errors='replace'))
        for descriptor in (process / 'fd').iterdir():
            with suppress(OSError):  # closed meanwhile
                found.append(os.readlink(descriptor))
    return {match[1] for text in found for match in NAME.finditer(text)}


def unused(folder: Path = SHARED_MEMORY, settled: float = SETTLING_TIME_S,
           leaving: bool = False) -> Iterator[Path]:
    """Yield the files that no living process uses; see clean for the arguments.

    A file is used if a process holds its lock or has it mapped, or if it belongs to another user.
    Each yielded file stays locked until the next is asked for, so that no process takes the port
    while it is removed.
    """
    groups: dict[str, list[Path]] = {}
    for file in folder.glob('*_*'):
        if match := NAME.fullmatch(file.name):
            groups.setdefault(match[1], []).append(file)
    mapped = _mapped_files(os.getpid() if leaving else None) if groups else set()
    for name, files in groups.items():
        with ExitStack() as locks, suppress(FileNotFoundError):  # the owner ended just now
            if any(_may_be_used(file.stat(), mapped, settled) for file in files):
                continue
            if all(_lock(file, locks) for file in files):
                yield from files
                yield from folder.glob(f'sem.{name}_mutex')


def _may_be_used(state: os.stat_result, mapped: set[tuple[int, int]], settled: float) -> bool:
    return (state.st_uid != os.geteuid() or time.time() - state.st_mtime < settled
            or (state.st_dev, state.st_ino) in mapped)


def _lock(file: Path, locks: ExitStack) -> bool:
    """Lock a file until ``locks`` ends; return whether the lock was free."""
    try:
        fcntl.flock(locks.enter_context(file.open('rb')), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _mapped_files(leaving: int | None) -> set[tuple[int, int]]:
    """Return device and inode of the files of Fast DDS that processes have mapped.

    Left out are processes that we may not inspect, and the one with the id ``leaving``.
    """
    found = set()
    for maps in Path('/proc').glob('[0-9]*/maps'):
        if maps.parent.name == str(leaving):
            continue
        try:
            lines = maps.read_text(errors='replace').splitlines()
        except OSError:  # it ended, or belongs to somebody else
            continue
        for line in lines:  # address, permissions, offset, device, inode, path
            if 'fastrtps_' in line:
                _, _, _, device, inode, _ = line.split(maxsplit=5)
                major, minor = (int(number, 16) for number in device.split(':'))
                found.add((os.makedev(major, minor), int(inode)))
    return found
