"""Options that name a design, and where it lies."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from bpc_perception.core.design.comparison import WantedDesign
from bpc_perception.core.design.registration import place_at, Registration
from bpc_perception.display.units import MM_PER_M
from bpc_perception.files.design.read import read_design

DesignOption = Annotated[Path | None, typer.Option(
    '--design', metavar='FILE', help='What the print was to be: G-code, or a CSV path; how far it '
    'is from that goes into report and summary.')]
PlaceOption = Annotated[str, typer.Option(
    '--design-at', metavar='X,Y,Z,YAW', help="Where the design's origin lies in the robot base "
    'frame [mm] and by how much it is turned about z [degrees]; else it is found from the path.')]
InkOnOption = Annotated[list[str] | None, typer.Option(
    '--ink-on', metavar='COMMAND', help='Command of the G-code that switches ink on, as "M42 P32 '
    'S255", where it is not E; may be repeated.')]
InkOffOption = Annotated[list[str] | None, typer.Option(
    '--ink-off', metavar='COMMAND', help='Command that switches it off; may be repeated.')]


def wanted_design(file: Path | None, place: str, ink_on: list[str] | None,
                  ink_off: list[str] | None) -> WantedDesign | None:
    """Return the design that is named; None = none. Raises ValueError if it cannot be read."""
    if file is None:
        if place or ink_on or ink_off:
            raise ValueError('--design-at, --ink-on, --ink-off: expected a design, found none'
                             '; name its file with --design')
        return None
    design = read_design(file, ink_on or (), ink_off or ())
    return WantedDesign(str(file), design, _place(place) if place else None)


def _place(words: str) -> Registration:
    """Return where a design lies that is told as 'x,y,z,yaw' [mm, degrees]."""
    try:
        x, y, z, yaw = map(float, words.split(','))
    except ValueError:
        raise ValueError(f'--design-at: expected four numbers as 500,20,10,90, found {words}'
                         '; give x, y and z in millimetres and yaw in degrees') from None
    return place_at(x / MM_PER_M, y / MM_PER_M, z / MM_PER_M, float(np.radians(yaw)))
