"""The ``bpc`` command.

Typer makes options, types and help from the signatures of the functions.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
import gc
from importlib.metadata import entry_points, EntryPoint
import logging
import sys
from typing import Any, NoReturn

import typer

from bpc_perception.cli.command_help import help_of
from bpc_perception.cli.parts.terminal import show_held_warnings, WARNINGS
from bpc_perception.display.plain_text import one_line
from bpc_perception.runtime.exit_status import INTERRUPTED, REFUSED
from bpc_perception.runtime.transport import shared_memory
from bpc_perception.runtime.transport.dds_profiles import choose_profile

# This class is of Click, which newer versions of Typer contain under another name.
UsageError: Any = typer.BadParameter.__base__
GROUP = 'bpc.commands'  # of entry points

# The module and the function of each command. Only that of the command which is called is loaded:
# all of them take a second.
COMMANDS = {name: f'bpc_perception.cli.{place}' for name, place in (
    ('demo', 'replay:demo'), ('test', 'test_suite:run_tests'), ('measure', 'measure:measure'),
    ('replay', 'replay:replay'), ('live', 'live:live'), ('record', 'record:record'),
    ('recover', 'recover:recover'), ('batch', 'batch:batch'), ('compare', 'compare:compare'),
    ('printability', 'printability.command:printability'), ('testprint', 'testprint:app'),
    ('window', 'window.command:window'), ('check', 'check:check'), ('calibrate', 'calibrate:app'))}


def command_line(words: Sequence[str] | None = None) -> typer.Typer:
    """Return the command line, with the command that words begin with.

    Where they begin with none it has all, which only tell what they are for. Without words, all
    are loaded.
    """
    commands = [EntryPoint(name, place, GROUP) for name, place in COMMANDS.items()]
    if not words or words[0] not in COMMANDS:
        # Those of other packages, for example of the simulator where it is installed.
        commands += sorted(set(entry_points(group=GROUP)))
    called = commands if words is None else [each for each in commands if each.name in words[:1]]
    app = typer.Typer(add_completion=False, rich_markup_mode=None,
                      pretty_exceptions_enable=False,
                      help='Live thickness feedback for robotic bioprinting. Also: ./bpc env '
                           'prints the environment, for colcon and tools run by hand.')
    app.callback()(_nothing)  # or a single command would need no name
    for command in called:
        loaded = command.load()
        if isinstance(loaded, typer.Typer):
            app.add_typer(loaded, name=command.name)
        else:
            app.command(command.name)(loaded)
    if not called:
        for command in commands:
            app.command(command.name, help=help_of(command))(_not_first)
    return app


def _nothing() -> None:
    pass


def _not_first() -> None:
    raise ValueError('expected the command as the first word, found another; see ./bpc --help')


def main() -> None:
    """Run the command; one line on stderr and exit status 2 for what cannot be done."""
    choose_profile()
    # Clean here, before any node starts: a node would do it while others run.
    shared_memory.clean()
    logging.getLogger().addHandler(WARNINGS)
    try:
        words = sys.argv[1:] or ['--help']
        gc.disable()  # what is loaded stays: to look through it for what does not takes a while
        commands = command_line(words)
        gc.freeze()
        gc.enable()
        status = commands(words, prog_name='bpc', standalone_mode=False)
    except UsageError as error:
        command = error.ctx.command_path if error.ctx else 'bpc'
        refuse(f'{command}: {error.format_message()} ({command} --help says more)')
    except (ValueError, OSError) as error:
        refuse(f'bpc: {error}' + ''.join(f'; {text}' for text in WARNINGS.texts))
    except typer.Abort:  # Ctrl-C
        sys.exit(INTERRUPTED)
    finally:
        shared_memory.clean(leaving=True)  # of nodes whose memory others still had mapped
    show_held_warnings()
    sys.exit(status)


def refuse(reason: str) -> NoReturn:
    """End the command with this reason as one line on stderr."""
    with suppress(OSError):  # nobody reads it, and the status tells as well
        print(one_line(reason), file=sys.stderr)
    sys.exit(REFUSED)
