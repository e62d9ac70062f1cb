"""Options that name a design, and where it lies."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.core.config import ThicknessConfig

DesignOption = Annotated[Path | None, typer.Option(
    '--design', metavar='FILE', help='What the print was to be: G-code, or a CSV path; how far it '
    'is from that goes into verdict, report, table and summary.')]
PlaceOption = Annotated[str, typer.Option(
    '--design-at', metavar='X,Y,Z,YAW', help="Where the design's origin lies in the robot base "
    'frame [mm] and by how much it is turned about z [degrees]; else it is found from the path.')]
InkOnOption = Annotated[list[str] | None, typer.Option(
    '--ink-on', metavar='COMMAND', help='Command of the G-code that switches ink on, as "M42 P32 '
    'S255", where it is not E; may be repeated.')]
InkOffOption = Annotated[list[str] | None, typer.Option(
    '--ink-off', metavar='COMMAND', help='Command that switches it off; may be repeated.')]


def with_design(thickness: ThicknessConfig, file: Path | None, place: str,
                ink_on: list[str] | None, ink_off: list[str] | None) -> ThicknessConfig:
    """Return settings with what the options tell of a design: they count before those."""
    given = {'file': str(file) if file is not None else '', 'place': place,
             'ink_on': ';'.join(ink_on or ()), 'ink_off': ';'.join(ink_off or ())}
    design = replace(thickness.design, **{name: value for name, value in given.items() if value})
    if not design.file and any(given.values()):
        raise ValueError('--design-at, --ink-on, --ink-off: expected a design, found none'
                         '; name its file with --design')
    return replace(thickness, design=design)
