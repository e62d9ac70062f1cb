"""Prints in layers, measured while they grow: each layer beside its truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from bpc_perception.core.amounts import amount_of
from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.cross_section.incremental import PrintMemory
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_sim.ink.bead_sizes import sizes_above
from bpc_sim.ink.deposit import Deposit
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
VOLUME_STEPS = 400  # along a stroke, of its true volume
END_M = 3e-4  # from the end of a stroke, within which any answer is right
NAMES = ('stack', 'wall', 'lattice', 'lattice_curved')
TRANSLUCENT, INK_DEPTH_M = 'translucent', 2e-4  # a stack whose points lie so deep


@dataclass(frozen=True)
class MeasuredLayers:
    """A print that was measured.

    Attributes:
        name: of the scenario.
        layers: the widths beside the truth, layer by layer.
        sizes: heights and areas beside the truth, layer by layer.
        volumes: (3, S) of the strokes of each layer: measured, its sigma, and in truth [m^3].
    """

    name: str
    layers: list[Comparison]
    sizes: list[Sizes]
    volumes: list[Array]


@dataclass(frozen=True)
class Sizes:
    """Heights [m] and areas [m^2] of N measured samples of one layer, and what they are in truth.

    Attributes:
        height, area: (3, N) measured, its sigma, and in truth.
    """

    height: Array
    area: Array


VOLUME_COLUMNS = 'volume_error', 'volume_within_1_sigma', 'volume_within_2_sigma'
SIZE_COLUMNS = ('height_MAE_mm', 'area_error', 'area_bias', 'height_within_1_sigma',
                'height_within_2_sigma', 'area_within_1_sigma', 'area_within_2_sigma')


def tasks(seeds: int) -> list[tuple[str, float, int]]:
    """Return scenario, tilt of the camera [degrees] and seed of each task."""
    return [(name, tilt, seed)
            for name in (*NAMES, TRANSLUCENT) for tilt in TILTS_DEG for seed in range(seeds)]


def measure_print(task: tuple[str, float, int]) -> MeasuredLayers:
    """Print, measure each capture, and compare what is known at the end."""
    job = print_job(*task)
    profile = measure_job(job)
    return MeasuredLayers(task[0], compare_layers(job, profile), compare_sizes(job, profile),
                          compare_volumes(job, profile))


def print_job(name: str, tilt: float, seed: int) -> PrintJob:
    """Return a print that a camera sees tilted [degrees]."""
    rng = seeded(f'{name} {tilt:g}', seed)
    deep = name == TRANSLUCENT
    return replace(SCENARIOS['stack' if deep else name](SPEED_M_PER_S), seed=seed,
                   sensor=Sensor(depth_noise=DEPTH_NOISE_M, ink_depth=INK_DEPTH_M * deep),
                   view=CameraPlacement(CAMERA_M, np.radians(tilt), SIZE_PX).view(rng))


def measure_job(job: PrintJob, missed: int = 0) -> ThicknessProfile:
    """Return what is known of a print at its end.

    Args:
        job: the print.
        missed: of its captures, so many of the first are not measured.
    """
    path = recorded_path(job, START_NS)
    memory = PrintMemory()
    config = ThicknessConfig()
    for number, capture in enumerate(islice(captures(job), missed, None)):
        profile = measure(capture, path, job.view.T_base_camera, config, number, memory)
    return profile


def captures(job: PrintJob) -> Iterator[Capture]:
    """Yield the captures of a print: one now and then while ink is laid, and one at its end."""
    times = np.arange(job.dwell_before + CAPTURE_PERIOD_S, job.duration, CAPTURE_PERIOD_S)
    laid = job.laid(times)
    news = np.append(np.diff(laid) > 0, True)  # not while it only waits
    for number, time in enumerate((*times[news].tolist(), job.duration)):
        yield job.capture(time, number, START_NS + round(time * 1e9))


def compare_layers(job: PrintJob, profile: ThicknessProfile) -> list[Comparison]:
    """Compare the widths of a print with the truth, layer by layer."""
    width = job.commanded.width(true_arc(job, profile))
    return [Comparison(width[own], np.full(own.sum(), Truth.MEASURED, np.uint8),
                       profile.status[own], profile.thickness[own], profile.sigma[own],
                       np.array((profile.processing_time,)))
            for own in of_each_layer(job, profile)]


def compare_sizes(job: PrintJob, profile: ThicknessProfile) -> list[Sizes]:
    """Compare heights and areas of a print with the truth, layer by layer."""
    arc, ink = true_arc(job, profile), job.laid_layers(job.duration)
    found = []
    for number, own in enumerate(of_each_layer(job, profile)):
        own &= profile.status == Status.MEASURED
        height, area = sizes_above(ink[number], ink[:number], arc[own])
        found.append(Sizes(
            np.stack((profile.height[own], profile.height_sigma[own], height)),
            np.stack((profile.area[own], profile.area_sigma[own], area))))
    return found


def compare_volumes(job: PrintJob, profile: ThicknessProfile) -> list[Array]:
    """Compare the volumes of the strokes of a print with the truth, layer by layer."""
    ink, found = job.laid_layers(job.duration), []
    for number, (begin, end) in enumerate(job.layers.tolist()):
        volumes = []
        for stroke, (start, stop) in enumerate(job.commanded.runs.tolist(), start=1):
            if begin <= start < end:
                s = start + (stop - start) * (np.arange(VOLUME_STEPS) + 0.5) / VOLUME_STEPS
                _, area = sizes_above(ink[number], ink[:number], s)
                measured = amount_of(profile, profile.stroke == stroke)
                volumes.append((measured.volume, measured.volume_sigma,
                                float(area.mean()) * length_of(job, ink[number], s)))
        found.append(np.array(volumes).T)
    return found


def length_of(job: PrintJob, bead: Deposit, s: Array) -> float:
    """Return how long the ink is whose N equal parts have their middles at arc lengths s (N,) [m].

    Around a cylinder, ink is the longer, the higher it lies. It counts where its weight is, at
    two fifths of the height of a parabola.
    """
    middle = job.surface.points(bead.curve.points(s), bead.base(s) + 0.4 * (
        bead.height_ratio * bead.width(s)))
    between = float(np.linalg.norm(np.diff(middle, axis=0), axis=1).sum())
    return between * len(s) / (len(s) - 1)


def true_arc(job: PrintJob, profile: ThicknessProfile) -> Array:
    """Return the arc lengths (N,) on the commanded path of the samples of a profile [m]."""
    return job.laid(profile.time + (profile.print_start_ns - START_NS) * 1e-9)


def of_each_layer(job: PrintJob, profile: ThicknessProfile) -> list[Flags]:
    """Return which samples (N,) are of the strokes of each layer, away from their ends."""
    arc = true_arc(job, profile)
    from_end = np.abs(arc[:, None] - job.commanded.runs.ravel()).min(axis=1)
    layer = np.searchsorted(job.layers[:, 0], arc, side='right') - 1
    chosen = (job.commanded.width(arc) > 0) & (from_end > END_M) & (profile.stroke > 0)
    return [chosen & (layer == number) for number in range(len(job.layers))]


def rows(found: list[MeasuredLayers]) -> list[Row]:
    """Return a row for each layer of each scenario, from all views and seeds together."""
    table = []
    for name in dict.fromkeys(one.name for one in found):
        prints = [one for one in found if one.name == name]
        layers = zip(zip(*(one.layers for one in prints), strict=True),
                     zip(*(one.sizes for one in prints), strict=True),
                     zip(*(one.volumes for one in prints), strict=True), strict=True)
        for number, (widths, sizes, volumes) in enumerate(layers):
            line = row(name, 'cross_section', merge(widths))
            table.append({'scene': name, 'layer': number} | {
                key: line[key] for key in ('samples', 'MAE_mm', 'median_mm', 'max_mm', 'answered',
                                           'wrong', 'within_1_sigma', 'within_2_sigma')}
                | size_columns(sizes) | volume_columns(volumes))
    return table


def volume_columns(volumes: Sequence[Array]) -> Row:
    """Return how far the volumes of strokes are off."""
    volume, sigma, true = np.concatenate(volumes, axis=1)
    known = np.isfinite(volume)
    if not known.any():
        return dict.fromkeys(('strokes', *VOLUME_COLUMNS), np.nan) | {'strokes': 0}
    volume, sigma, true = volume[known], sigma[known], true[known]
    off = np.abs(volume - true)
    return {'strokes': len(volume), 'volume_error': float((off / true).mean()),
            'volume_within_1_sigma': float((off <= sigma).mean()),
            'volume_within_2_sigma': float((off <= 2 * sigma).mean())}


def size_columns(sizes: Sequence[Sizes]) -> Row:
    """Return how far heights and areas are off."""
    height, sigma, true_height = np.concatenate([one.height for one in sizes], axis=1)
    area, area_sigma, true_area = np.concatenate([one.area for one in sizes], axis=1)
    known = np.isfinite(height)
    error, off = np.abs(height - true_height)[known], np.abs(area - true_area)[known]
    if not known.any():
        return dict.fromkeys(SIZE_COLUMNS, np.nan) | {'sized': 0.0, 'height_fair': 1.0}
    return {'sized': float(known.mean()),
            'height_fair': 1 - float(np.mean(error > 2 * sigma[known]) * known.mean()),
            'height_MAE_mm': float(error.mean()) * 1e3,
            'area_error': float((off / true_area[known]).mean()),
            'area_bias': float((area / true_area)[known].mean()) - 1,
            'height_within_1_sigma': float((error <= sigma[known]).mean()),
            'height_within_2_sigma': float((error <= 2 * sigma[known]).mean()),
            'area_within_1_sigma': float((off <= area_sigma[known]).mean()),
            'area_within_2_sigma': float((off <= 2 * area_sigma[known]).mean())}


LAYERS = Study('Prints in layers, each layer beside its truth', tasks, measure_print, rows,
               processes=2)
