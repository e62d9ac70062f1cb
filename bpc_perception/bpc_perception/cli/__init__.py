"""The ``bpc`` command.

Built with Typer, which makes options, types and help from the functions' own signatures.
"""

from __future__ import annotations

import logging
import sys

import typer

from bpc_perception.cli import live, measure, record, replay, sim, study, testing

REFUSED = 2

app = typer.Typer(no_args_is_help=True, add_completion=False, rich_markup_mode=None,
                  pretty_exceptions_enable=False,
                  help='Live thickness feedback for robotic bioprinting.')
for name, command in (('demo', replay.demo), ('test', testing.run_tests),
                      ('measure', measure.measure), ('replay', replay.replay),
                      ('live', live.live), ('sim', sim.sim), ('record', record.record),
                      ('study', study.study)):
    app.command(name)(command)


def main() -> None:
    """Run the command; one line on stderr and exit status 2 for what cannot be done."""
    logging.basicConfig(level=logging.WARNING, format='%(message)s')
    try:
        app(prog_name='bpc')
    except (ValueError, OSError) as error:
        print(f'bpc: {error}', file=sys.stderr)
        sys.exit(REFUSED)
