"""The paper's two scaling figures: time and error over resolution and over thickness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bpc_sim.studies.paper.cases import make_case
from bpc_sim.studies.paper.drawing import DRAWINGS
from bpc_sim.studies.paper.measuring import compare_case
from bpc_sim.studies.study_runner import METHODS, Row, Study
from bpc_sim.studies.truth_comparison import Comparison, merge

GAP_COUNT = 10
SWEEP_WIDTH_M = 2e-3  # at all resolutions


@dataclass(frozen=True)
class Setting:
    """One print of a sweep.

    Attributes:
        ratio: resolution relative to 512 x 512 pixels of 0.1 mm.
        width: width of the filament [m].
        seed: places the gaps; even seeds are Archimedean spirals, odd ones Fermat's.
    """

    ratio: float
    width: float
    seed: int


@dataclass(frozen=True)
class MeasuredPrint:
    """A print, measured by each method.

    Attributes:
        setting: the print.
        size: width and height of the image [pixels].
        comparisons: the comparison with the truth by method.
    """

    setting: Setting
    size: int
    comparisons: dict[str, Comparison]


def measure_print(setting: Setting) -> MeasuredPrint:
    """Draw a print area-sampled and measure it by each method."""
    case = make_case('AF'[setting.seed % 2], setting.width, setting.width, GAP_COUNT,
                     rng=np.random.default_rng(setting.seed), ratio=setting.ratio)
    image = DRAWINGS['area'].image(case, setting.seed)
    return MeasuredPrint(setting, case.size, compare_case(case, image))


def rows(found: list[MeasuredPrint]) -> list[Row]:
    """Return a row for each method and setting, with the means over its prints."""
    table: list[Row] = []
    for method in METHODS:
        for ratio, width in sorted({(one.setting.ratio, one.setting.width) for one in found}):
            prints = [one for one in found
                      if (one.setting.ratio, one.setting.width) == (ratio, width)]
            all_of = merge([one.comparisons[method] for one in prints])
            mae = float(np.nanmean(np.abs(all_of.thickness - all_of.true)))
            table.append({
                'ratio': ratio, 'size_px': prints[0].size, 'width_mm': width * 1e3,
                'method': method, 'prints': len(prints),
                'time_ms': float(all_of.time.mean()) * 1e3, 'MAE_mm': mae * 1e3,
                'MAE_percent': mae / width * 100, 'answered': all_of.answered})
    return table


def over_resolution(seeds: int) -> Sequence[Setting]:
    """Return ten ratios from 1/4 to 2, in turn: a busy machine slows all of them alike."""
    return [Setting(float(ratio), SWEEP_WIDTH_M, seed) for seed in range(seeds)
            for ratio in np.linspace(0.25, 2, 10)]


def over_thickness(seeds: int) -> Sequence[Setting]:
    """Return ten widths from 0.4 mm to 4 mm, in turn."""
    return [Setting(1.0, float(width), seed) for seed in range(seeds)
            for width in np.linspace(0.4e-3, 4e-3, 10)]


RESOLUTION = Study('Resolution: 2 mm wide, ten random gaps, area-sampled; ratio 1 is 0.1 mm/px',
                   over_resolution, measure_print, rows, seeds=10,
                   axes=('ratio', 'time_ms', 'MAE_percent'))
THICKNESS = Study('Thickness: 512 x 512 pixels of 0.1 mm, ten random gaps, area-sampled',
                  over_thickness, measure_print, rows, seeds=10,
                  axes=('width_mm', 'time_ms', 'MAE_percent'))
