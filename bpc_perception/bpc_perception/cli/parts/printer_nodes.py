"""The nodes of a printer that is played by this command: simulated, or from a recording."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bpc_perception.cli.parts.live_page import keep_page_open, serving
from bpc_perception.cli.parts.monitor import Monitor
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.runtime.child_processes import Nodes


@contextmanager
def printer_nodes(monitor: Monitor, terminal: Terminal, page: bool, parameter_file: Path | None,
                  **parameters: Any) -> Iterator[Nodes]:
    """Give the block nodes to start, with the page if wanted; all end with the block.

    When the block has ended by itself, the page stays open for a person at the terminal.

    Args:
        monitor: follows the nodes.
        terminal: of the command.
        page: whether to serve the page.
        parameter_file: for all nodes but the page; None = none.
        parameters: for all nodes.

    Raises:
        ValueError: a printer is there already; or the page cannot be served.
    """
    with (Nodes(parameter_file, parameters) as nodes,
          serving(page, terminal, **parameters)):
        monitor.expect_no_other_printer()
        yield nodes
        keep_page_open(page, terminal, monitor)
