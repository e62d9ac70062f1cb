"""Ray-traced scenes, each beside its truth: pictures that the suite does not draw itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_sim.raytraced.catalogue import SCENES
from bpc_sim.raytraced.crops import load
from bpc_sim.raytraced.spec import Half
from bpc_sim.studies.stress_study import row
from bpc_sim.studies.study_runner import Row, Study
from bpc_sim.studies.truth_comparison import compare_scene, Comparison, merge


@dataclass(frozen=True)
class MeasuredCrop:
    """A ray-traced scene that was measured.

    Attributes:
        name: of the scene.
        half: of the scenes that it belongs to.
        comparison: what was measured beside the truth.
    """

    name: str
    half: Half
    comparison: Comparison


def tasks(_: int) -> list[int]:
    """Return the numbers of all scenes: each was traced once."""
    return list(range(len(SCENES)))


def measure_crop(number: int) -> MeasuredCrop:
    """Measure a scene as it is kept in its file."""
    scene = SCENES[number]
    return MeasuredCrop(scene.name, scene.half,
                        compare_scene(scene.scene(load(scene)), 'cross_section'))


def rows(found: list[MeasuredCrop]) -> list[Row]:
    """Return a row for each scene, and one for each half."""
    table = [line(one.name, one.half.value, one.comparison) for one in found]
    for half in dict.fromkeys(one.half for one in found):
        table.append(line('all', half.value, merge([
            one.comparison for one in found if one.half is half])))
    return table


def line(scene: str, half: str, measured: Comparison) -> Row:
    """Return how a scene was measured."""
    error = measured.error[np.isfinite(measured.error)]
    known = row(scene, 'cross_section', measured)
    return {'scene': scene, 'half': half, 'samples': known['samples'],
            'answered': known['answered'], 'MAE_mm': known['MAE_mm'],
            'bias_mm': float(error.mean()) * 1e3 if len(error) else np.nan,
            'max_mm': known['max_mm'], 'wrong': known['wrong'],
            'within_1_sigma': known['within_1_sigma'], 'within_2_sigma': known['within_2_sigma']}


RAYTRACED = Study('Ray-traced scenes of known truth', tasks, measure_crop, rows, processes=2)
