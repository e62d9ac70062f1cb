"""Shared memory of Fast DDS that processes left behind which were killed.

Each participant has a segment ``fastrtps_<16 hexadecimal digits>`` of up to 70 MB, and each port
on which it listens ``fastrtps_port<number>`` with ``sem.fastrtps_port<number>_mutex``. Beside both
lies an empty file, ``..._el`` or ``..._sl``, on which the owner holds a lock (flock) as long as it
lives [Fast DDS 2.14, src/cpp/utils/shared_memory and tools/fastdds/shm].

Our own profiles, ``bpc_<random>.xml``, lie there while a node is made, locked by themselves.
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
SETTLED = 2.0  # a younger file may be of a process that has not locked it yet [s]


def clean(folder: Path = SHARED_MEMORY, settled: float = SETTLED,
          among: Container[str] | None = None, leaving: bool = False) -> int:
    """Remove what no living process uses, of these names if any are given; how many bytes.

    A process that is ``leaving`` may still have mapped what others left.
    """
    freed = 0
    for file in unused(folder, settled, leaving):
        name = NAME.search(file.name)
        if among is not None and (name is None or name[1] not in among):
            continue
        with suppress(OSError):  # someone else was quicker
            size = file.stat().st_size
            file.unlink()
            freed += size
    return freed


def used_by(pid: int) -> set[str]:
    """Names of what a process has mapped or open there; none if it has ended."""
    process, found = Path(f'/proc/{pid}'), []
    with suppress(OSError):
        found.append((process / 'maps').read_text(errors='replace'))
        for descriptor in (process / 'fd').iterdir():
            with suppress(OSError):  # closed meanwhile
                found.append(os.readlink(descriptor))
    return {match[1] for text in found for match in NAME.finditer(text)}


def unused(folder: Path = SHARED_MEMORY, settled: float = SETTLED,
           leaving: bool = False) -> Iterator[Path]:
    """The files that no living process uses, or no other where this one is leaving.

    In use is what someone holds the lock of or has mapped, or what belongs to another user. Each
    is kept locked until the next is asked for, so that nobody takes the port while it is removed.
    """
    groups: dict[str, list[Path]] = {}
    for file in folder.glob('*_*'):
        if match := NAME.fullmatch(file.name):
            groups.setdefault(match[1], []).append(file)
    mapped = _mapped_files(os.getpid() if leaving else None) if groups else set()
    for name, files in groups.items():
        with ExitStack() as locks, suppress(FileNotFoundError):  # its owner ended just now
            states = [file.stat() for file in files]
            if not (any(state.st_uid != os.geteuid() or time.time() - state.st_mtime < settled
                        or (state.st_dev, state.st_ino) in mapped for state in states)
                    or any(not _lock(file, locks) for file in files)):
                yield from files
                yield from folder.glob(f'sem.{name}_mutex')


def _lock(file: Path, locks: ExitStack) -> bool:
    """Whether its lock can be had; then it is held."""
    try:
        fcntl.flock(locks.enter_context(file.open('rb')), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _mapped_files(leaving: int | None) -> set[tuple[int, int]]:
    """Device and inode of the files of Fast DDS that a process we may look at has mapped.

    But for one that is leaving.
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
