"""The stress scenes, measured by both methods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bpc_sim.stress.catalogue import STRESS
from bpc_sim.studies.study_runner import METHODS, Row, Study
from bpc_sim.studies.truth_comparison import compare_scene, Comparison, merge


@dataclass(frozen=True)
class MeasuredScene:
    """A scene of some seed, measured by each method.

    Attributes:
        scene: name of the scene.
        comparisons: the comparison with the truth by method.
    """

    scene: str
    comparisons: dict[str, Comparison]


def tasks(seeds: int) -> list[tuple[str, int]]:
    """Return scene and seed of each task."""
    return [(scene, seed) for scene in STRESS for seed in range(seeds)]


def measure_scene(task: tuple[str, int]) -> MeasuredScene:
    """Build a scene and measure it by each method."""
    name, seed = task
    scene = STRESS[name](seed)
    return MeasuredScene(name, {method: compare_scene(scene, method) for method in METHODS})


def merge_seeds(found: Sequence[MeasuredScene], method: str) -> dict[str, Comparison]:
    """Return the comparison of each scene by a method, with all seeds together."""
    return {scene: merge([one.comparisons[method] for one in found if one.scene == scene])
            for scene in dict.fromkeys(one.scene for one in found)}


def rows(found: list[MeasuredScene]) -> list[Row]:
    """Return a row for each method and scene, and one for all scenes of a method."""
    return [row(scene, method, comparison)
            for method in METHODS
            for scene, comparison in (
                *merge_seeds(found, method).items(),
                ('all', merge([one.comparisons[method] for one in found])))]


def row(scene: str, method: str, measured: Comparison) -> Row:
    """Return what is right, refused and wrong."""
    return {
        'scene': scene, 'method': method, 'samples': len(measured.true),
        'MAE_mm': measured.mae * 1e3, 'median_mm': measured.median_error * 1e3,
        'max_mm': measured.largest_error * 1e3, 'answered': measured.answered,
        'wrong': measured.wrong, 'gap_called_material': measured.gap_called_material,
        'material_called_gap': measured.material_called_gap,
        'unknowable': measured.unknowable, 'guessed': measured.guessed,
        'within_1_sigma': measured.within(1), 'within_2_sigma': measured.within(2)}


STRESS_SCENES = Study('Stress scenes of known truth', tasks, measure_scene, rows, processes=2)
