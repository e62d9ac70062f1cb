"""Walk through a tutorial: run its commands as a reader does, one after the other."""

from __future__ import annotations

from pathlib import Path
import shlex

from bpc_system_tests.documentation.pages import blocks, code, DOCS
from bpc_system_tests.parts.command_line import succeed

NEW_INK = DOCS / 'tutorials' / 'new_ink.md'


def walk(page: Path, folder: Path) -> str:
    """Run the commands of all shell blocks of a page in a folder; each has to succeed.

    Returns:
        All that they said.
    """
    lines = [each.text for each in code(page) if each.in_block]
    return ''.join(succeed(*shlex.split(line.removeprefix('./bpc')), folder=folder)
                   for line in lines)


def quoted(text: str) -> list[str]:
    """Return the lines that a page says a command says."""
    return [line for block in blocks(text, 'text') for line in block.splitlines()]
