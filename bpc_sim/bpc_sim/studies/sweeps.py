"""The paper's two scaling figures: time and error over the resolution and over the thickness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bpc_perception.core.config import ThicknessConfig
from bpc_sim.studies.cases import DRAWINGS, measure_case
from bpc_sim.studies.comparison import compare_profile, Comparison, together
from bpc_sim.studies.paper_cases import make_case
from bpc_sim.studies.study import METHODS, Row, Study

GAPS = 10
WIDTH = 2e-3  # at all resolutions [m]


@dataclass(frozen=True)
class Setting:
    """One print of a sweep.

    Attributes:
        ratio: resolution relative to 512 x 512 pixels of 0.1 mm.
        width: of the filament [m].
        seed: places the gaps; even ones are Archimedean spirals, odd ones Fermat's.
    """

    ratio: float
    width: float
    seed: int


@dataclass(frozen=True)
class Measured:
    """A print, measured by each method."""

    setting: Setting
    size: int
    measured: dict[str, Comparison]


def work(setting: Setting) -> Measured:
    """Draw a print area-sampled and measure it."""
    case = make_case('AF'[setting.seed % 2], setting.width, setting.width, GAPS,
                     rng=np.random.default_rng(setting.seed), ratio=setting.ratio)
    image = DRAWINGS['area'].image(case, setting.seed)
    return Measured(setting, case.size, {
        method: compare_profile(measure_case(case, ThicknessConfig(method=method), image),
                                case.thickness)
        for method in METHODS})


def rows(found: list[Measured]) -> list[Row]:
    """A row for each method and setting, the mean over its prints."""
    table: list[Row] = []
    for method in METHODS:
        for ratio, width in sorted({(one.setting.ratio, one.setting.width) for one in found}):
            prints = [one for one in found
                      if (one.setting.ratio, one.setting.width) == (ratio, width)]
            all_of = together([one.measured[method] for one in prints])
            mae = float(np.nanmean(np.abs(all_of.thickness - all_of.true)))
            table.append({
                'ratio': ratio, 'size_px': prints[0].size, 'width_mm': width * 1e3,
                'method': method, 'prints': len(prints),
                'time_ms': float(all_of.time.mean()) * 1e3, 'MAE_mm': mae * 1e3,
                'MAE_percent': mae / width * 100, 'answered': all_of.answered})
    return table


def over_resolution(seeds: int) -> Sequence[Setting]:
    """Ten ratios from 1/4 to 2, in turn, so that a busy machine slows all of them alike."""
    return [Setting(float(ratio), WIDTH, seed) for seed in range(seeds)
            for ratio in np.linspace(0.25, 2, 10)]


def over_thickness(seeds: int) -> Sequence[Setting]:
    """Ten widths from 0.4 mm to 4 mm, in turn."""
    return [Setting(1.0, float(width), seed) for seed in range(seeds)
            for width in np.linspace(0.4e-3, 4e-3, 10)]


RESOLUTION = Study('Resolution: 2 mm wide, ten random gaps, area-sampled; ratio 1 is 0.1 mm/px',
                   over_resolution, work, rows, seeds=10,
                   axes=('ratio', 'time_ms', 'MAE_percent'))
THICKNESS = Study('Thickness: 512 x 512 pixels of 0.1 mm, ten random gaps, area-sampled',
                  over_thickness, work, rows, seeds=10,
                  axes=('width_mm', 'time_ms', 'MAE_percent'))
