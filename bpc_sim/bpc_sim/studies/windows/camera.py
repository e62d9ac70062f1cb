"""The lines of a sweep as a synthetic camera sees them, and the widths measured of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.printability.uncertainty import sigma_of_mean
from bpc_perception.core.profile import Status
from bpc_perception.core.window.sweep import SweepLine
from bpc_sim.printer.motion import Travel
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.recorded_path import recorded_path
from bpc_sim.printer.scenarios import parallel_lines, stroke_job
from bpc_sim.scene.scene import Sensor
from bpc_sim.stress.camera_placement import CameraPlacement
from bpc_sim.studies.windows.ink_law import InkLaw
from bpc_sim.studies.windows.printed_sweep import END_M, LEVELS, LINE_M, Setting, swept

PITCH_M = 8e-3
CAMERA_M, SIZE_PX = 0.30, (456, 342)  # 0.11 mm a pixel
DEPTH_NOISE_M = 8e-5
START_NS = 1_700_000_000_000_000_000
LEAST_SEEN = 0.5  # of a line, or its width is not known


def see_sweep(ink: InkLaw, printed: list[Setting], rng: np.random.Generator) -> list[SweepLine]:
    """Return what is measured of lines, printed LEVELS at a time beside each other."""
    lines: list[SweepLine] = []
    for first in range(0, len(printed), LEVELS):
        together = printed[first:first + LEVELS]
        job = print_job(ink, together, rng)
        lines += [swept(ink, line, first + index + 1, width, sigma)
                  for index, (line, (width, sigma)) in enumerate(
                      zip(together, measured(job), strict=True))]
    return lines


def print_job(ink: InkLaw, lines: list[Setting], rng: np.random.Generator) -> PrintJob:
    """Return the print of lines of one speed, with a camera somewhere above it."""
    speed = lines[0].speed
    job = stroke_job(parallel_lines(len(lines), PITCH_M, LINE_M), speed, Travel(0, 0, 2e-3))
    runs = job.commanded.runs
    s = np.linspace(0, LINE_M, 200)
    # As long as it builds up it is wide enough to be drawn.
    along = [np.maximum(line.factor * ink.along(line.flow, speed, s), 1e-4)
             if np.isfinite(line.width) else np.full(len(s), 1e-3) for line in lines]
    places = np.concatenate([start + s for start in runs[:, 0].tolist()])
    widths = np.concatenate(along)
    broken = [not np.isfinite(line.width) for line in lines]
    view = CameraPlacement(CAMERA_M, float(rng.uniform(0, np.radians(15))), SIZE_PX).view(rng)
    return replace(job, printed_width=lambda at: np.interp(at, places, widths),
                   faults=runs[broken], view=view, seed=int(rng.integers(2**31)),
                   sensor=Sensor(depth_noise=DEPTH_NOISE_M))


def measured(job: PrintJob) -> list[tuple[float, float]]:
    """Return mean width of each line and its uncertainty [m], but for its ends; NaN = unknown."""
    profile = measure(job.capture(job.duration, 0, START_NS + round(job.duration * 1e9)),
                      recorded_path(job, START_NS), job.view.T_base_camera, ThicknessConfig(), 0)
    found = []
    for stroke in range(1, len(job.commanded.runs) + 1):
        own = profile.stroke == stroke
        arc = profile.arc_length
        start, end = arc[own].min(), arc[own].max()
        own &= (arc > start + END_M) & (arc < end - END_M)
        seen = own & (profile.status == Status.MEASURED)
        if seen.sum() < LEAST_SEEN * own.sum():
            found.append((np.nan, np.nan))
        else:
            sigma = sigma_of_mean(profile.sigma[seen], LINE_M - 2 * END_M, 1)
            found.append((float(profile.thickness[seen].mean()), sigma))
    return found
