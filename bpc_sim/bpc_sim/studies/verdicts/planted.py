"""Prints as they come out of a good printer, and the same with one defect planted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.design.comparison import WantedDesign
from bpc_perception.core.inspection.defects import DefectKind
from bpc_sim.ink.deposit import Deposit, WidthProfile
from bpc_sim.printer.motion import Travel
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import parallel_lines, SCENARIOS, stroke_job
from bpc_sim.scene.scene import Sensor
from bpc_sim.stress.camera_placement import CameraPlacement
from bpc_sim.studies.verdicts.designed import design_of, wanted

SPEED_M_PER_S = 0.01
SOUND = ('line', 'ring', 'meander', 'strokes', 'archimedean', 'dense', 'stack', 'crosshatch')
CAMERA_M, SIZE_PX = 0.30, (304, 228)  # 0.17 mm a pixel
DEPTH_NOISE_M = 8e-5
MOST_TILT_RAD = np.radians(20)
# How evenly a good printer lays ink: over long stretches, and from one millimetre to the next.
LONG_M, LONG_SHARE = 0.02, 0.025
SHORT_M, SHORT_SHARE = 2e-3, 0.015
DEFECT_M = 6e-3  # length of a stretch that is thin, thick or a neck
STROKE = 2  # of five, from 0, that has the defect
LINES = parallel_lines(5, 6e-3, 0.03)
WIDTH_M = 2e-3


@dataclass(frozen=True, eq=False)
class OozingJob(PrintJob):
    """A print whose nozzle drips behind a stroke.

    Attributes:
        ooze: (2,) arc lengths on travel between which ink lies [m].
    """

    ooze: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def deposit(self) -> Deposit:
        """Ink of the complete print, in the surface frame."""
        start, end = self.ooze
        gaps = [((first, last) if not first <= start < last else (end, last))
                for first, last in self.commanded.gaps.tolist()]
        return replace(super().deposit, gaps=np.array(gaps))


@dataclass(frozen=True)
class Planted:
    """A print with a defect.

    Attributes:
        job: the print.
        extent: arc lengths between which the defect is [m].
        shift: how far the path is told to the left of where it is [m].
        design: of the print, where that matters.
    """

    job: PrintJob
    extent: tuple[float, float]
    shift: float = 0.0
    design: WantedDesign | None = None


def sound_print(number: int) -> PrintJob:
    """Return a sound print: ink as even as a good printer lays it, seen from anywhere."""
    rng = np.random.default_rng(number)
    job = SCENARIOS[SOUND[number % len(SOUND)]](SPEED_M_PER_S)
    return seen(replace(job, printed_width=uneven(job.commanded.profile, job.length, rng),
                        faults=np.empty((0, 2))), rng, number)


def seen(job: PrintJob, rng: np.random.Generator, number: int) -> PrintJob:
    """Return a print with a camera at a random place and tilt."""
    placement = CameraPlacement(CAMERA_M, float(rng.uniform(0, MOST_TILT_RAD)), SIZE_PX)
    return replace(job, seed=number, view=placement.view(rng),
                   sensor=Sensor(depth_noise=DEPTH_NOISE_M))


def uneven(profile: WidthProfile, length: float, rng: np.random.Generator) -> WidthProfile:
    """Return widths that vary at random around those of a profile."""
    waves = []
    for period, share in ((LONG_M, LONG_SHARE), (SHORT_M, SHORT_SHARE)):
        places = np.arange(-period, length + 2 * period, period)
        waves.append((places, share * rng.standard_normal(len(places)).clip(-2, 2)))
    return lambda s: profile(s) * (1 + sum(np.interp(s, *wave) for wave in waves))


def planted(kind: DefectKind, size: float, number: int) -> Planted:
    """Return a print with a defect of a size.

    Args:
        kind: of the defect.
        size: share of the width or height; of GAP, OOZE, MISSING_STROKE and SKIPPED the length
            [m].
        number: which print.
    """
    rng = np.random.default_rng(number)
    lines = LINES.copy()
    if kind == DefectKind.OOZE:  # so that it does not run into the stroke
        lines[1::2] = lines[1::2, ::-1]
    if kind == DefectKind.MISSING_STROKE:
        lines[STROKE, 1, 0] = lines[STROKE, 0, 0] + size
    design = None
    if kind in (DefectKind.OFF_DESIGN, DefectKind.SKIPPED):
        away = size * WIDTH_M if kind == DefectKind.OFF_DESIGN else 0.0
        meant = stroke_job(lines, SPEED_M_PER_S, Travel(0, 0, 2e-3), WIDTH_M)
        design = wanted(design_of(meant), away * meant.T_base_surface[:3, 1])
        lines[STROKE, 1, 0] -= size if kind == DefectKind.SKIPPED else 0.0
    job = stroke_job(lines, SPEED_M_PER_S, Travel(0, 0, 2e-3), WIDTH_M)
    start, end = job.commanded.runs[STROKE].tolist()
    middle = (start + end) / 2
    even = uneven(job.commanded.profile, job.length, rng)
    extent, shift = (middle - DEFECT_M / 2, middle + DEFECT_M / 2), 0.0
    match kind:
        case DefectKind.THIN | DefectKind.THICK:
            sign = 1 if kind == DefectKind.THICK else -1
            job = replace(job, printed_width=scaled(even, extent, lambda _: sign * size))
        case DefectKind.NECK:
            job = replace(job, printed_width=scaled(
                even, extent, lambda part: -size * np.sin(np.pi * part)**2))
        case DefectKind.LOW | DefectKind.HIGH:
            sign = 1 if kind == DefectKind.HIGH else -1
            ink = job.commanded
            extent = (start, end)
            job = replace(job, printed_width=even, commanded=replace(
                ink, height_ratio=ink.height_ratio * (1 + sign * size)))
        case DefectKind.OFF_PATH:
            extent, shift = (start, end), size * WIDTH_M
            job = replace(job, printed_width=even)
        case DefectKind.OFF_DESIGN | DefectKind.SKIPPED:
            extent = (start, end)
            job = replace(job, printed_width=even)
        case DefectKind.GAP | DefectKind.MISSING_STROKE:
            extent = ((middle - size / 2, middle + size / 2) if kind == DefectKind.GAP
                      else (start, end))
            job = replace(job, printed_width=even, faults=np.array((extent,)))
        case DefectKind.OOZE:
            extent = (end, end + size)
            fields = {name: getattr(job, name) for name in job.__dataclass_fields__}
            job = OozingJob(**{**fields, 'printed_width': even}, ooze=extent)
    return Planted(seen(job, rng, number), extent, shift, design)


def scaled(profile: WidthProfile, extent: tuple[float, float],
           change: Callable[[Array], Array | float]) -> WidthProfile:
    """Return widths that change by a share, which depends on the part 0..1 of an extent."""
    start, end = extent

    def width(s: Array) -> Array:
        part = (s - start) / (end - start)
        return profile(s) * np.where((part > 0) & (part < 1), 1 + change(part), 1.0)

    return width
