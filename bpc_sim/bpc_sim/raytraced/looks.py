"""How ink, beds and lamps of ray-traced scenes look. Colours are linear, 0 to 1."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Ink:
    """Of what a bead is.

    Attributes:
        colour: of opaque ink; of translucent ink, what its inside scatters back.
        roughness: of its surface; wet ink has 0.05 to 0.2.
        translucent: whether light goes into it.
        extinction: of light in translucent ink [1/m].
    """

    colour: Colour
    roughness: float = 0.1
    translucent: bool = False
    extinction: float = 2500.0


class Bed(Enum):
    """What ink is printed on."""

    PAPER = 'paper'
    SKIN = 'skin'
    TISSUE = 'wet tissue'
    METAL = 'brushed metal'
    GRID = 'printed millimetre grid'
    PLASTIC = 'dark plastic'


class Lamp(Enum):
    """What lights a scene, beside the camera's own projector and the room."""

    SOFT = 'room only'
    TUBE = 'long tube'
    SPOT = 'spot from the side'
