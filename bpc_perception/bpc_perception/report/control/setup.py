"""What prints were made and measured with: those on one chart have to have the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any

from bpc_perception.display.units import MM_PER_M
from bpc_perception.report.result_folder import part_of

# The beginnings of the names of settings that change what is wanted or what is measured.
DECIDING = ('method', 'segmentation.', 'cross_section.', 'advice.target_', 'tolerance.')
# Those that name files: they are alike where the contents are.
FILES = 'advice.target_file', 'design.file'
NOZZLE = 'path_recorder.nozzle_offset'
# The same nozzle, calibrated again, is alike; needles of other lengths differ by some millimetres.
NOZZLE_MM = 1.0
SHOWN = 12  # characters of a hash, which 48 bits tell apart
FOCAL_SHARE = 0.02  # the same lens, calibrated again, differs by less
Band = tuple[float, float, str]


@dataclass(frozen=True)
class Setup:
    """What a print was made and measured with.

    Attributes:
        settings: the deciding ones, by dotted names, as in summary.json; of files that are
            named, the content by its hash, or the name where that is not told.
        designed: whether the design tells widths, or may.
        nozzle: offset of its tip from the flange [mm]; empty = not told.
        image: width and height [pixels]; empty = not told.
        focal_length: of the camera [pixels]; NaN = not told.
    """

    settings: dict[str, object]
    designed: bool
    nozzle: tuple[float, ...]
    image: tuple[int, ...]
    focal_length: float

    @classmethod
    def of(cls, summary: dict[str, Any]) -> Setup:
        """Return that of a print, by its summary."""
        told, camera = part_of(summary, 'settings'), part_of(summary, 'camera')
        nozzle, contents = told.get(NOZZLE), part_of(summary, 'contents')
        files = {name: f'content {str(contents[name])[:SHOWN]}' if name in contents else told[name]
                 for name in FILES if told.get(name)}
        return cls(
            {name: value for name, value in told.items()
             if name.startswith(DECIDING) and name not in FILES} | files,
            'design.file' in files and _tells_widths(part_of(summary, 'design')),
            tuple(MM_PER_M * number_of(value)
                  for value in (nozzle if isinstance(nozzle, list) else ())),
            tuple(camera[side] for side in ('width_px', 'height_px') if side in camera),
            number_of(camera.get('focal_length_px')))

    def is_like(self, other: Setup) -> bool:
        """Return whether prints made with both belong on one chart."""
        return (self.settings == other.settings and self.image == other.image
                and len(self.nozzle) == len(other.nozzle)
                and all(abs(one - two) < NOZZLE_MM
                        for one, two in zip(self.nozzle, other.nozzle, strict=True))
                and (math.isclose(self.focal_length, other.focal_length, rel_tol=FOCAL_SHARE)
                     or (math.isnan(self.focal_length) and math.isnan(other.focal_length))))

    def width(self) -> Band:
        """Return the least and largest width that is good [mm], and why there are none."""
        if self.settings.get('advice.target_file'):
            return math.nan, math.nan, 'the target changes along the path'
        if self.designed:
            return math.nan, math.nan, 'the design tells the target'
        return self._band('advice.target_thickness', 'tolerance.width')

    def height(self) -> Band:
        """Return the least and largest height that is good [mm], and why there are none."""
        return self._band('tolerance.target_height', 'tolerance.height')

    def named(self) -> dict[str, str]:
        """Return everything in words, by names."""
        nozzle = ', '.join(f'{value:.1f}' for value in self.nozzle)
        return {**{name: str(value) for name, value in self.settings.items()},
                f'{NOZZLE} [mm]': nozzle, 'image [pixels]': ' × '.join(map(str, self.image)),
                'focal length [pixels]': f'{self.focal_length:.0f}'}

    def _band(self, target_name: str, tolerance_name: str) -> Band:
        target, share = (number_of(self.settings.get(name)) for name in (
            target_name, tolerance_name))
        for value, name in ((target, target_name), (share, tolerance_name)):
            if not value > 0:
                return math.nan, math.nan, f'{name} is not set'
        return MM_PER_M * target * (1 - share), MM_PER_M * target * (1 + share), ''


def _tells_widths(design: dict[str, Any]) -> bool:
    """Return whether a design tells widths, by its entry in a summary, or may where it is lost."""
    return part_of(design, 'width_off').get('samples') != 0


def not_alike(setups: Sequence[Setup]) -> list[tuple[str, list[str]]]:
    """Return in what setups differ: names, and the values of each in words."""
    words = [setup.named() for setup in setups]
    names = dict.fromkeys(name for each in words for name in each)
    values = [(name, [each.get(name, '-') for each in words]) for name in names]
    return [(name, each) for name, each in values if len(set(each)) > 1]


def number_of(value: object) -> float:
    """Return a number of a summary; NaN where it has none."""
    return float(value) if isinstance(value, int | float) else math.nan
