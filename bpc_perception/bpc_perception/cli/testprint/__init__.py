"""``bpc testprint``: prints that are made to be measured, written and judged."""

from __future__ import annotations

import typer

from bpc_perception.cli.testprint import judging, writing

app = typer.Typer(help='Write a print that is made to be measured, and judge its recording.')
for name, command in (('lines', writing.lines), ('fusion', writing.fusion),
                      ('turns', writing.turns), ('lattice', writing.lattice),
                      ('line-over-lines', writing.line_over_lines), ('wall', writing.wall),
                      ('judge', judging.judge)):
    app.command(name)(command)
