"""Widths by how much filament is pushed in, where a slicer says how it reckons."""

from __future__ import annotations

from dataclasses import dataclass
import math
import re

MM = 1e-3
# Slic3r and its heirs write their settings into comments.
SETTING = re.compile(r'^; (filament_diameter|extrusion_multiplier|layer_height|first_layer_height|'
                     r'z_offset|use_volumetric_e) = ([\d.,%-]{1,100})\r?$', re.M)
ON_LEVEL_MM = 1e-3


@dataclass(frozen=True)
class ExtrudedWidth:
    """Settings of a file [mm]; NaN = not told.

    Attributes:
        filament: diameter for each tool.
        multiplier: of the flow for each tool.
        layer, first: heights of the layers, and of the first one.
        offset: of z.
    """

    filament: tuple[float, ...]
    multiplier: tuple[float, ...]
    layer: float
    first: float
    offset: float

    @classmethod
    def of(cls, text: str) -> ExtrudedWidth:
        """Return the settings in a file."""
        told = dict(SETTING.findall(text))
        layer = _numbers(told, 'layer_height')[0]
        first = told.get('first_layer_height', '')
        share = re.fullmatch(r'(\d+\.?\d*)%', first)
        filament = _numbers(told, 'filament_diameter')
        if told.get('use_volumetric_e') != '0':
            filament = (math.nan,)
        return cls(filament, _numbers(told, 'extrusion_multiplier'), layer,
                   layer * float(share[1]) / 100 if share
                   else _numbers(told, 'first_layer_height')[0],
                   _numbers(told, 'z_offset')[0])

    def at(self, step: float, length: float, z: float, tool: int) -> float:
        """Return the width of a bead [m]; NaN = not known.

        The cross-section is a rectangle with round ends, as Slic3r reckons (Flow.cpp).

        Args:
            step: of E [mm].
            length: of the move [mm].
            z: of the nozzle, all along it [mm].
            tool: that lays it.
        """
        height = self._height(z)
        if tool >= min(len(self.filament), len(self.multiplier)) or not length > 0:
            return math.nan
        area = math.pi / 4 * self.filament[tool]**2 * step / length
        width = area / self.multiplier[tool] / height + height * (1 - math.pi / 4)
        return width * MM if width >= height else math.nan

    def _height(self, z: float) -> float:
        """Return the height of the layer at z [mm]; NaN where the settings have none."""
        above = z - self.offset - self.first
        number = above / self.layer
        if not (number > -0.5 and abs(above - round(number) * self.layer) <= ON_LEVEL_MM):
            return math.nan
        return self.first if round(number) == 0 else self.layer


def _numbers(told: dict[str, str], name: str) -> tuple[float, ...]:
    """Return the numbers of a setting; NaN where it has none, or one that is not above 0."""
    values = told.get(name, '').split(',')
    found = tuple(float(value) if re.fullmatch(r'-?\d+\.?\d*', value) else math.nan
                  for value in values)
    least = -math.inf if name == 'z_offset' else 0.0
    return tuple(value if least < value < 1e3 else math.nan for value in found)
