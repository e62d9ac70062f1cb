"""The stress scenes, and among them the paper's hardware prints, by both methods."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.stress.scenes import STRESS
from bpc_sim.studies.comparison import compare, Comparison, together
from bpc_sim.studies.study import METHODS, Row, Study

REPORTED = {  # mean, standard deviation, quartiles [mm]; the paper's second table
    'hardware_line': (2.135, 1.280, 0.917, 2.790, 3.322),
    'hardware_fermat': (1.569, 0.289, 1.352, 1.479, 1.769),
    'hardware_archimedean': (1.604, 0.330, 1.428, 1.593, 1.847),
    'hardware_archimedean_gaps': (1.575, 0.411, 1.424, 1.586, 1.827),
}
STATISTICS = ('mean_mm', 'std_mm', 'q1_mm', 'q2_mm', 'q3_mm')


@dataclass(frozen=True)
class Measured:
    """A scene of some seed, measured by each method."""

    scene: str
    measured: dict[str, Comparison]


def tasks(seeds: int) -> list[tuple[str, int]]:
    """Scene and seed."""
    return [(scene, seed) for scene in STRESS for seed in range(seeds)]


def hardware_tasks(seeds: int) -> list[tuple[str, int]]:
    """Print and seed."""
    return [(scene, seed) for scene in REPORTED for seed in range(seeds)]


def work(task: tuple[str, int]) -> Measured:
    """Build a scene and measure it."""
    name, seed = task
    scene = STRESS[name](seed)
    return Measured(name, {method: compare(scene, method) for method in METHODS})


def rows(found: list[Measured]) -> list[Row]:
    """A row for each method and scene, its seeds taken together, and one for all of a method."""
    return [row(scene, method, all_of)
            for method in METHODS
            for scene, all_of in (*grouped(found, method).items(),
                                  ('all', together([one.measured[method] for one in found])))]


def row(scene: str, method: str, measured: Comparison) -> Row:
    """What is right, refused and wrong."""
    return {
        'scene': scene, 'method': method, 'samples': len(measured.true),
        'MAE_mm': measured.mae * 1e3, 'median_mm': measured.median_error * 1e3,
        'max_mm': measured.largest_error * 1e3, 'answered': measured.answered,
        'wrong': measured.wrong, 'gap_called_material': measured.gap_called_material,
        'material_called_gap': measured.material_called_gap,
        'unknowable': measured.unknowable, 'guessed': measured.guessed,
        'within_1_sigma': measured.within(1), 'within_2_sigma': measured.within(2)}


def hardware_rows(found: list[Measured]) -> list[Row]:
    """Statistics over material as measured, true and as the paper reports them of its prints."""
    table: list[Row] = []
    for method in METHODS:
        for scene, measured in grouped(found, method).items():
            line: Row = {'print': scene.removeprefix('hardware_'), 'method': method}
            for name, *values in zip(
                    STATISTICS, statistics(measured.thickness), statistics(measured.true),
                    REPORTED[scene], strict=True):
                line.update(zip((name, f'true_{name}', f'paper_{name}'), values, strict=True))
            table.append({**line, 'MAE_mm': measured.mae * 1e3, 'answered': measured.answered})
    return table


def statistics(widths: Array) -> tuple[float, ...]:
    """Mean, standard deviation and quartiles [mm] of the widths (N,) [m] of material."""
    material = widths[widths > 0] * 1e3
    if not len(material):
        return (np.nan,) * len(STATISTICS)
    return (float(material.mean()), float(material.std()),
            *(float(quartile) for quartile in np.percentile(material, (25, 50, 75))))


def grouped(found: list[Measured], method: str) -> dict[str, Comparison]:
    """Each scene, its seeds taken together."""
    return {scene: together([one.measured[method] for one in found if one.scene == scene])
            for scene in dict.fromkeys(one.scene for one in found)}


STRESS_STUDY = Study('Stress scenes of known truth', tasks, work, rows, processes=2)
HARDWARE = Study("The paper's four hardware prints, re-enacted with the camera's noise",
                 hardware_tasks, work, hardware_rows, processes=2)
