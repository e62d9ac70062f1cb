"""The sockets of processes, and which of them other computers can reach."""

from __future__ import annotations

from dataclasses import dataclass
import ipaddress
import os
from pathlib import Path
import socket
import sys
import time

TCP_LISTEN = '0A'  # state of a socket, tcp_states.h of Linux
READING_TIME_S = 0.5  # within which whoever reads a socket has read


@dataclass(frozen=True)
class Socket:
    """A socket that accepts what anybody sends: TCP that listens, or UDP without a peer.

    Attributes:
        protocol: tcp, tcp6, udp or udp6.
        address, port: where it is bound.
        waiting: received bytes that nobody has read.
    """

    protocol: str
    address: str
    port: int
    waiting: int


def parse_address(text: str) -> tuple[str, int]:
    """Return address and port from the form of /proc/net: words in the machine's byte order."""
    host, port = text.split(':')
    words = bytes.fromhex(host)
    if sys.byteorder == 'little':
        words = b''.join(words[i:i + 4][::-1] for i in range(0, len(words), 4))
    return str(ipaddress.ip_address(words)), int(port, 16)


def open_files(process: int) -> set[str]:
    """Return the targets of all file descriptors of a process."""
    found = set()
    for descriptor in Path(f'/proc/{process}/fd').iterdir():
        try:
            found.add(os.readlink(descriptor))
        except FileNotFoundError:  # closed meanwhile
            continue
    return found


def sockets(process: int) -> list[Socket]:
    """Return the sockets of a process that accept what anybody sends."""
    own = open_files(process)
    found = []
    for protocol in ('tcp', 'tcp6', 'udp', 'udp6'):
        table = Path(f'/proc/{process}/net/{protocol}')
        for line in table.read_text().splitlines()[1:] if table.exists() else ():
            fields = line.split()
            without_peer = int(fields[2].split(':')[1], 16) == 0
            listens = fields[3] == TCP_LISTEN if protocol.startswith('tcp') else without_peer
            if listens and f'socket:[{fields[9]}]' in own:
                found.append(Socket(protocol, *parse_address(fields[1]),
                                    int(fields[4].split(':')[1], 16)))
    return found


def is_read(process: int, place: Socket) -> bool:
    """Tell whether somebody reads what arrives at a UDP socket.

    Fast DDS sends through other sockets, at ports that change, and never reads from those.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        unspecified = ipaddress.ip_address(place.address).is_unspecified
        host = '127.0.0.1' if unspecified else place.address
        sender.sendto(b'knock', (host, place.port))
    end = time.monotonic() + READING_TIME_S
    while time.monotonic() < end:
        now = {(each.protocol, each.port): each.waiting for each in sockets(process)}
        if now.get((place.protocol, place.port), 0) > place.waiting:
            return False  # it has arrived, and waits
        time.sleep(0.01)
    return True


def open_to_others(process: int, allowed: str = '127.0.0.1') -> list[Socket]:
    """Return the sockets that read from addresses other than loopback and the allowed one."""
    found = []
    for each in sockets(process):
        address = ipaddress.ip_address(each.address)
        if address.is_loopback or each.address == allowed or address.is_multicast:
            continue
        if each.protocol.startswith('tcp') or is_read(process, each):
            found.append(each)
    return found


def address_in_the_network() -> str:
    """Return the address of this computer towards others; empty where it has no network."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as towards:
        try:
            towards.connect(('198.51.100.1', 9))  # reserved for documents; nothing is sent
        except OSError:
            return ''
        return str(towards.getsockname()[0])
