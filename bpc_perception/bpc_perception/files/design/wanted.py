"""Read the design that settings name."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bpc_perception.core.config import DesignConfig
from bpc_perception.core.design.comparison import WantedDesign
from bpc_perception.core.design.registration import place_at, Registration
from bpc_perception.display.units import MM_PER_M
from bpc_perception.files.design.read import read_design


def wanted_design(config: DesignConfig, file: str | Path | None = None) -> WantedDesign | None:
    """Return the design that is named; None = none.

    Args:
        config: how it is read.
        file: that counts instead of the one there; empty or None = no other.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is no design, or is told to lie nowhere; the message says what to do.
    """
    name = str(file or config.file)
    if not name:
        return None
    design = read_design(name, _commands(config.ink_on), _commands(config.ink_off))
    return WantedDesign(name, design, place_told(config.place) if config.place else None)


def _commands(words: str) -> list[str]:
    """Return commands that have ; between them, as G-code has before its comments."""
    return [command.strip() for command in words.split(';') if command.strip()]


def place_told(words: str) -> Registration:
    """Return where a design lies that is told as 'x,y,z,yaw' [mm, degrees]."""
    try:
        x, y, z, yaw = map(float, words.split(','))
    except ValueError:
        raise ValueError(f'design place: expected four numbers as 500,20,10,90, found {words}'
                         '; give x, y and z in millimetres and yaw in degrees') from None
    return place_at(x / MM_PER_M, y / MM_PER_M, z / MM_PER_M, float(np.radians(yaw)))
