"""Claim a ROS domain of this computer: two suites in one would mix, whoever started them.

The claim is the name of an abstract Unix socket. It needs no file, so it holds for all users and
where nothing can be written; the kernel gives it back when the last process that has it ends. The
nodes of a command have it, too. So nobody begins beside those of a command that was killed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import errno
import os
import socket
import struct
import time

from bpc_perception.claims.holder import described, HeldError, is_alive

NAME = '\0bpc/domain/{}'
MOST_ASKERS = 4096  # who ask for the holder; nobody answers, the kernel knows it
CREDENTIALS = 'iII'  # of SO_PEERCRED: ids of process, user and group
ENDING_PATIENCE_S = 40.0  # for nodes of a command that was killed: a report may be long
ENDING_CHECK_PERIOD_S = 0.1

_claims: list[socket.socket] = []  # of this process


def domain() -> str:
    """Return the ROS domain of this process."""
    return os.environ.get('ROS_DOMAIN_ID') or '0'


def descriptors() -> tuple[int, ...]:
    """Return what the nodes of this process inherit, so that they have its claim, too."""
    return tuple(claim.fileno() for claim in _claims)


def holder() -> int | None:
    """Return the id of the process that claimed the domain; None = nobody, 0 = not known."""
    with socket.socket(socket.AF_UNIX) as asker:
        asker.setblocking(False)
        try:
            asker.connect(NAME.format(domain()))
        except ConnectionRefusedError:
            return None
        except OSError:
            return 0
        raw = asker.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize(CREDENTIALS))
        return int(struct.unpack(CREDENTIALS, raw)[0])


def refusal(pid: int) -> str:
    """Return why nobody else can begin in the domain that a process has."""
    found = (described(pid) if pid == 0 or is_alive(pid) else
             f'nodes of a command that was killed, process {pid}')
    return (f'ROS domain {domain()}: expected no other suite in it, found {found}; stop it, or '
            'set ROS_DOMAIN_ID to another number')


def expect_free() -> None:
    """Raise HeldError if a command has the domain."""
    pid = holder()
    if pid is not None:
        raise HeldError(refusal(pid))


@contextmanager
def claimed(say: Callable[[str], None]) -> Iterator[None]:
    """Have the ROS domain of this process during the block.

    The nodes of a command that was killed are waited for, which is said.

    Raises HeldError if another command has it.
    """
    with socket.socket(socket.AF_UNIX) as claim:
        _take(claim, say)
        _claims.append(claim)
        try:
            yield
        finally:
            _claims.remove(claim)


def _take(claim: socket.socket, say: Callable[[str], None]) -> None:
    end, waits = time.monotonic() + ENDING_PATIENCE_S, False
    while True:
        try:
            claim.bind(NAME.format(domain()))
            claim.listen(MOST_ASKERS)
            return
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                return  # there are no such names here
        pid = holder()
        if pid is not None:  # otherwise it has given it back just now
            if pid == 0 or is_alive(pid) or time.monotonic() > end:
                raise HeldError(refusal(pid))
            if not waits:
                say(f'ROS domain {domain()}: waiting for the nodes of a command that was killed.')
                waits = True
        time.sleep(ENDING_CHECK_PERIOD_S)
