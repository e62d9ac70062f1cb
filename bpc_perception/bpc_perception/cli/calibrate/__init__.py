"""``bpc calibrate``: nozzle offset and hand-eye calibration from recordings, and their check."""

from __future__ import annotations

import typer

from bpc_perception.cli.calibrate import check, hand_eye, nozzle

app = typer.Typer(help='Find the nozzle offset and the hand-eye calibration, and check them.')
for command in (nozzle.nozzle, hand_eye.handeye, check.check):
    app.command()(command)
