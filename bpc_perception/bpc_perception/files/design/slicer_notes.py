"""What slicers say in comments: layers, widths, and the settings that widths come from."""

from __future__ import annotations

from configparser import Error, RawConfigParser
import json
import re

from bpc_perception.core.config import LARGEST_TARGET_M, LEAST_TARGET_M
from bpc_perception.files.design.refusals import refusal

MM = 1e-3
# PrusaSlicer, SuperSlicer, OrcaSlicer; Bambu Studio.
NEXT_LAYER = re.compile(r'(?:CHANGE_LAYER|LAYER_CHANGE)$')
# Cura; KISSlicer, Simplify3D; by hand.
NUMBERED_LAYER = re.compile(r'layer(?:\s*:\s*|\s+)(-?\d{1,6})(?![\d.])', re.I)
WIDTH = re.compile(r'(?:WIDTH|LINE_WIDTH)\s*:\s*([-+.\deE]+)$')  # PrusaSlicer; Bambu Studio
KIND = re.compile(r'TYPE\s*:\s*(\S.*)$')
CURA_SETTINGS = re.compile(r'^;SETTING_3 (.*)$', re.M)
# The setting of Cura that tells the width of each of its kinds of line. What is not set for one
# of them is as line_width (fdmprinter.def.json of Cura).
CURA_WIDTHS = {
    'WALL-OUTER': 'wall_line_width_0', 'WALL-INNER': 'wall_line_width_x',
    'SKIN': 'skin_line_width', 'FILL': 'infill_line_width', 'SKIRT': 'skirt_brim_line_width',
    'SUPPORT': 'support_line_width', 'SUPPORT-INTERFACE': 'support_interface_line_width',
    'PRIME-TOWER': 'prime_tower_line_width'}
FIRST_LAYER_FACTOR = 'initial_layer_line_width_factor'


class SlicerNotes:
    """The comments of a file so far.

    Attributes:
        layer: number of the layer as the file counts; None = not told.
    """

    def __init__(self, text: str) -> None:
        self.layer: int | None = None
        self._width = float('nan')
        self._kind = ''
        self._settings = cura_settings(text)

    def follow(self, comment: str, line: int) -> None:
        """Take in a comment. Raises DesignError at a width that is none."""
        if NEXT_LAYER.match(comment):
            self.layer = 0 if self.layer is None else self.layer + 1
        elif found := NUMBERED_LAYER.match(comment):
            self.layer = int(found[1])
        elif found := KIND.match(comment):
            self._kind = found[1]
        elif found := WIDTH.match(comment):
            self._width = _width(found[1], line)

    def width(self, tool: int) -> float:
        """Return the width that is wanted now [m]; NaN = not told."""
        if self._width == self._width:
            return self._width
        settings = self._settings.get(tool, {})
        name = CURA_WIDTHS.get(self._kind)
        # That of a first layer is by a factor of its own, unless it is set to 100 %.
        if name is None or (settings.get(FIRST_LAYER_FACTOR, 100.0) != 100.0 and self.layer == 0):
            return float('nan')
        found = settings.get(name, settings.get('line_width', float('nan'))) * MM
        return found if LEAST_TARGET_M <= found <= LARGEST_TARGET_M else float('nan')


def cura_settings(text: str) -> dict[int, dict[str, float]]:
    """Return the settings that Cura wrote at the end of a file, of each tool, as far as numbers.

    What is a formula is left out. Nothing where they cannot be read.
    """
    try:
        content = json.loads(''.join(CURA_SETTINGS.findall(text.replace('\r', ''))))
        shared = _numbers_of(content['global_quality'])
        return {tool: {**shared, **_numbers_of(part)}
                for tool, part in enumerate(content.get('extruder_quality', ['']))}
    except (ValueError, LookupError, TypeError, AttributeError, Error, RecursionError):
        return {}


def _numbers_of(part: str) -> dict[str, float]:
    """Return the values of a container of Cura that are numbers."""
    parser = RawConfigParser(strict=False)
    parser.read_string(part.replace('\\n', '\n'))
    values = parser['values'] if parser.has_section('values') else {}
    return {name: float(value) for name, value in values.items()
            if re.fullmatch(r'\d+\.?\d*', value)}


def _width(value: str, line: int) -> float:
    """Return the width [m] of a comment in millimetres."""
    try:
        width = float(value) * MM
    except ValueError:
        width = float('nan')
    if width == 0:  # PrusaSlicer writes it where nothing is laid
        return float('nan')
    if not LEAST_TARGET_M <= width <= LARGEST_TARGET_M:
        raise refusal(line, f'a width from {LEAST_TARGET_M / MM:g} to {LARGEST_TARGET_M / MM:g} '
                      'mm', value, 'correct it, or leave it out')
    return width
