"""The options of every command, made from the command line itself."""

from __future__ import annotations

from collections.abc import Iterator
import inspect
from typing import Any

import typer

from bpc_perception.cli.app import command_line
from bpc_system_tests.documentation.pages import DOCS

PAGE = DOCS / 'reference' / 'commands.md'
# Of Click, which Typer brings along under a name of its own.
Command = Any


def commands() -> dict[str, Command]:
    """Return every command by the words that call it, without those that only hold others."""
    return dict(_below(typer.main.get_command(command_line()), ''))


def _below(group: Command, name: str) -> Iterator[tuple[str, Command]]:
    for word, command in group.commands.items():
        full = f'{name} {word}'.strip()
        if hasattr(command, 'commands'):
            yield from _below(command, full)
        else:
            yield full, command


def context(name: str, command: Command) -> Any:
    """Return an empty context in which a command knows its own name."""
    return command.make_context(f'bpc {name}', [], resilient_parsing=True)


def option_tables() -> str:
    """Return the Markdown sections of all commands."""
    return '\n'.join(_section(name, command) for name, command in commands().items())


def _section(name: str, command: Command) -> str:
    ctx = context(name, command)
    rows = [record for each in command.params if (record := each.get_help_record(ctx))]
    table = ''.join(f'| `{option}` | {meaning} |\n' for option, meaning in rows)
    return (f'### {name}\n\n{inspect.cleandoc(command.help)}\n\n'
            f'| argument or option | meaning |\n|---|---|\n{table}')
