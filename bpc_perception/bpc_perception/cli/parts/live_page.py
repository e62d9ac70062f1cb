"""The option ``--page``: the live page beside a command's nodes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import importlib.util
import os
import secrets
import socket
from typing import Annotated, Any

import typer

from bpc_perception.cli.parts.monitor import Monitor
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import PageConfig
from bpc_perception.page import address_at, HOST, TOKEN_VARIABLE
from bpc_perception.runtime.child_processes import NodeError, Nodes

PageOption = Annotated[bool, typer.Option(
    '--page', help='Serve a page with picture, profile and advice on this computer.')]
TOKEN_BYTES = 16


@contextmanager
def serving(page: bool, terminal: Terminal, remappings: Mapping[str, str] | None = None,
            **parameters: Any) -> Iterator[None]:
    """Serve the page, if wanted, as long as the block runs, and say where it is.

    A command does not look after the page's process: a print goes on without a page.
    """
    if not page:
        yield
        return
    if importlib.util.find_spec('nicegui') is None:
        raise ValueError('--page: expected the Python package nicegui, found none'
                         '; install it, as with pip, or leave out --page')
    token = os.environ.setdefault(TOKEN_VARIABLE, secrets.token_urlsafe(TOKEN_BYTES))
    port = free_port(PageConfig().port)
    with Nodes(None, parameters, remappings) as nodes:
        nodes.start('bpc_perception.nodes.page', port=port)
        address = address_at(port, token)
        terminal.emit('page', f'page: {address}', address=address)
        yield
        try:
            nodes.check()
        except NodeError as error:
            terminal.warn(f'page: {error}')


def keep_page_open(page: bool, terminal: Terminal, monitor: Monitor) -> None:
    """Keep the page until Ctrl-C, if there is one and a person at the terminal."""
    if page and terminal.lively:
        terminal.say('The print has ended; nodes and page stay until Ctrl-C.')
        monitor.spin_until(lambda: False)


def free_port(preferred: int) -> int:
    """Return this port, or if it is taken any that is free now.

    Raises:
        OSError: none is free.
    """
    for port in (preferred, 0):
        try:
            with socket.create_server((HOST, port)) as free:
                return int(free.getsockname()[1])
        except OSError:
            continue
    raise OSError(f'expected a free port on {HOST}, found none; end what listens there')
