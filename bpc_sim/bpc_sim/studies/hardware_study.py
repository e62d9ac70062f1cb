"""The paper's four hardware prints, measured by both methods."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.studies.stress_study import measure_scene, MeasuredScene, merge_seeds
from bpc_sim.studies.study_runner import METHODS, Row, Study

REPORTED_MM = {  # mean, standard deviation, quartiles; the paper's second table
    'hardware_line': (2.135, 1.280, 0.917, 2.790, 3.322),
    'hardware_fermat': (1.569, 0.289, 1.352, 1.479, 1.769),
    'hardware_archimedean': (1.604, 0.330, 1.428, 1.593, 1.847),
    'hardware_archimedean_gaps': (1.575, 0.411, 1.424, 1.586, 1.827),
}
STATISTICS = ('mean_mm', 'std_mm', 'q1_mm', 'q2_mm', 'q3_mm')


def tasks(seeds: int) -> list[tuple[str, int]]:
    """Return print and seed of each task."""
    return [(scene, seed) for scene in REPORTED_MM for seed in range(seeds)]


def rows(found: list[MeasuredScene]) -> list[Row]:
    """Return statistics over material: measured, true, and as the paper reports its prints."""
    table: list[Row] = []
    for method in METHODS:
        for scene, measured in merge_seeds(found, method).items():
            line: Row = {'print': scene.removeprefix('hardware_'), 'method': method}
            for name, *values in zip(
                    STATISTICS, statistics(measured.thickness), statistics(measured.true),
                    REPORTED_MM[scene], strict=True):
                line.update(zip((name, f'true_{name}', f'paper_{name}'), values, strict=True))
            table.append({**line, 'MAE_mm': measured.mae * 1e3, 'answered': measured.answered})
    return table


def statistics(widths: Array) -> tuple[float, ...]:
    """Return mean, standard deviation and quartiles [mm] of the material in widths (N,) [m]."""
    material = widths[widths > 0] * 1e3
    if not len(material):
        return (np.nan,) * len(STATISTICS)
    return (float(material.mean()), float(material.std()),
            *(float(quartile) for quartile in np.percentile(material, (25, 50, 75))))


HARDWARE = Study("The paper's four hardware prints, re-enacted with the camera's noise",
                 tasks, measure_scene, rows, processes=2)
