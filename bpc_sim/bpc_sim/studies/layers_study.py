"""Prints in layers, measured while they grow: each layer beside its truth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.cross_section.incremental import PrintMemory
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.profile import ThicknessProfile
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.recorded_path import recorded_path
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_sim.scene.scene import Sensor
from bpc_sim.stress.camera_placement import CameraPlacement
from bpc_sim.stress.planar_print import seeded
from bpc_sim.stress.truth import Truth
from bpc_sim.studies.stress_study import row
from bpc_sim.studies.study_runner import Row, Study
from bpc_sim.studies.truth_comparison import Comparison, merge

SPEED_M_PER_S = 0.01
START_NS = 10**18
CAMERA_M, SIZE_PX = 0.30, (304, 228)  # 0.17 mm a pixel
DEPTH_NOISE_M = 8e-5  # at 0.4 m; 0.045 mm at the camera's distance
CAPTURE_PERIOD_S = 3.0
TILTS_DEG = (0.0, 25.0)
END_M = 3e-4  # from the end of a stroke, within which any answer is right
NAMES = ('stack', 'wall', 'lattice', 'lattice_curved')


@dataclass(frozen=True)
class MeasuredLayers:
    """A print that was measured.

    Attributes:
        name: of the scenario.
        layers: the comparison with the truth, layer by layer.
    """

    name: str
    layers: list[Comparison]


def tasks(seeds: int) -> list[tuple[str, float, int]]:
    """Return scenario, tilt of the camera [degrees] and seed of each task."""
    return [(name, tilt, seed) for name in NAMES for tilt in TILTS_DEG for seed in range(seeds)]


def measure_print(task: tuple[str, float, int]) -> MeasuredLayers:
    """Print, measure each capture, and compare what is known at the end."""
    name, tilt, seed = task
    rng = seeded(f'{name} {tilt:g}', seed)
    job = replace(SCENARIOS[name](SPEED_M_PER_S), seed=seed,
                  sensor=Sensor(depth_noise=DEPTH_NOISE_M),
                  view=CameraPlacement(CAMERA_M, np.radians(tilt), SIZE_PX).view(rng))
    path = recorded_path(job, START_NS)
    memory = PrintMemory()
    # A wall grows higher than the nozzle goes over a bed.
    config = ThicknessConfig(maximum_tip_height=0.02)
    for number, capture in enumerate(captures(job)):
        profile = measure(capture, path, job.view.T_base_camera, config, number, memory)
    return MeasuredLayers(name, compare_layers(job, profile))


def captures(job: PrintJob) -> Iterator[Capture]:
    """Yield the captures of a print: one now and then while ink is laid, and one at its end."""
    times = np.arange(job.dwell_before + CAPTURE_PERIOD_S, job.duration, CAPTURE_PERIOD_S)
    laid = job.laid(times)
    news = np.append(np.diff(laid) > 0, True)  # not while it only waits
    for number, time in enumerate((*times[news].tolist(), job.duration)):
        yield job.capture(time, number, START_NS + round(time * 1e9))


def compare_layers(job: PrintJob, profile: ThicknessProfile) -> list[Comparison]:
    """Compare the profile of a print with its truth, layer by layer."""
    arc = job.laid(profile.time + (profile.print_start_ns - START_NS) * 1e-9)
    width = job.commanded.width(arc)
    from_end = np.abs(arc[:, None] - job.commanded.runs.ravel()).min(axis=1)
    layer = np.searchsorted(job.layers[:, 0], arc, side='right') - 1
    chosen = (width > 0) & (from_end > END_M) & (profile.stroke > 0)
    return [Comparison(width[own], np.full(own.sum(), Truth.MEASURED, np.uint8),
                       profile.status[own], profile.thickness[own], profile.sigma[own],
                       np.array((profile.processing_time,)))
            for own in (chosen & (layer == number) for number in range(len(job.layers)))]


def rows(found: list[MeasuredLayers]) -> list[Row]:
    """Return a row for each layer of each scenario, from all views and seeds together."""
    table = []
    for name in dict.fromkeys(one.name for one in found):
        prints = [one.layers for one in found if one.name == name]
        for number, layer in enumerate(zip(*prints, strict=True)):
            line = row(name, 'cross_section', merge(layer))
            table.append({'scene': name, 'layer': number} | {
                key: line[key] for key in ('samples', 'MAE_mm', 'median_mm', 'max_mm', 'answered',
                                           'wrong', 'within_1_sigma', 'within_2_sigma')})
    return table


LAYERS = Study('Prints in layers, each layer beside its truth', tasks, measure_print, rows,
               processes=2)
