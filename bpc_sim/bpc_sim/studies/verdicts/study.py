"""False alarms on sound prints, and from which size on a planted defect is found."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.config import ThicknessConfig, ToleranceConfig
from bpc_perception.core.design.comparison import compare_with_design
from bpc_perception.core.inspection.defects import Defect, DefectKind
from bpc_perception.core.inspection.verdict import judge, Verdict
from bpc_perception.core.measurement.cross_section.incremental import PrintMemory
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.targets import WidthTargets
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.recorded_path import recorded_path
from bpc_sim.studies.layers_study import captures, START_NS
from bpc_sim.studies.study_runner import Row, Study
from bpc_sim.studies.verdicts.designed import design_of, wanted
from bpc_sim.studies.verdicts.planted import planted, sound_print, STROKE, WIDTH_M

SOUND_PRINTS_EACH = 10  # of one task, which has one seed
SIZES = 20  # of each kind of defect
LARGEST = {DefectKind.THIN: 0.4, DefectKind.THICK: 0.4, DefectKind.LOW: 0.6, DefectKind.HIGH: 0.6,
           DefectKind.OFF_PATH: 0.6, DefectKind.GAP: 6e-3, DefectKind.NECK: 0.6,
           DefectKind.OOZE: 5e-3, DefectKind.MISSING_STROKE: 0.02, DefectKind.OFF_DESIGN: 0.6,
           DefectKind.SKIPPED: 6e-3}
HEIGHT_M = 0.3 * WIDTH_M  # of the planted prints, above the bed
# A neck is looked for without a target: with one it is thin.
WITHOUT_TARGET = frozenset((DefectKind.NECK,))


@dataclass(frozen=True)
class Found:
    """What was said of a print.

    Attributes:
        kind: of the defect planted; None = a sound print.
        size: of it.
        verdict: on the print.
        defects: those found.
        hit: whether the one planted is among them.
    """

    kind: DefectKind | None
    size: float
    verdict: Verdict
    defects: tuple[Defect, ...]
    hit: bool = False


def tasks(seeds: int) -> list[tuple[DefectKind | None, int]]:
    """Return the kind of defect, None = sound prints, and the number of each task."""
    return [(kind, number) for kind in (None, *DefectKind)
            for number in range(seeds if kind is None else 1)]


def work(task: tuple[DefectKind | None, int]) -> list[Found]:
    """Measure and judge the prints of a task."""
    kind, number = task
    if kind is None:
        return [judge_sound(number * SOUND_PRINTS_EACH + each)
                for each in range(SOUND_PRINTS_EACH)]
    return [judge_planted(kind, size, each) for each, size in enumerate(
        (LARGEST[kind] * np.arange(1, SIZES + 1) / SIZES).tolist())]


def judge_sound(number: int) -> Found:
    """Judge a sound print by its design, which tells the width that it was meant to have."""
    job = sound_print(number)
    profile = measured(job)
    design = compare_with_design(profile, wanted(design_of(job)), recorded_path(job, START_NS))
    verdict = judge(profile, design.targets(profile.arc_length, None), ToleranceConfig(), True,
                    design=design)
    return Found(None, 0.0, verdict.verdict, verdict.defects)


def judge_planted(kind: DefectKind, size: float, number: int) -> Found:
    """Judge a print with a defect."""
    print_ = planted(kind, size, number)
    profile = measured(print_.job, print_.shift)
    targets = None if kind in WITHOUT_TARGET else WidthTargets.constant(WIDTH_M)
    design = compare_with_design(profile, print_.design) if print_.design else None
    verdict = judge(profile, targets, ToleranceConfig(target_height=HEIGHT_M), True,
                    design=design)
    start, end = (along(print_.job, profile, at) for at in print_.extent)
    hit = any(each.kind == kind and (each.stroke == STROKE + 1 if kind == DefectKind.SKIPPED else
                                     each.start <= end and each.end >= start)
              for each in verdict.defects)
    return Found(kind, size, verdict.verdict, verdict.defects, hit)


def measured(job: PrintJob, shift: float = 0.0) -> ThicknessProfile:
    """Return what is known of a print at its end.

    Args:
        job: the print.
        shift: how far the path is told beside where it is, along y of the bed [m].
    """
    path = recorded_path(job, START_NS)
    path = replace(path, points=path.points + shift * job.T_base_surface[:3, 1])
    memory = PrintMemory()
    for number, capture in enumerate(captures(job)):
        profile = measure(capture, path, job.view.T_base_camera, ThicknessConfig(), number,
                          memory)
    return profile


def along(job: PrintJob, profile: ThicknessProfile, arc_length: float) -> float:
    """Return the arc length [m] in a profile at one of the commanded path [m]."""
    laid = job.laid(profile.time + (profile.print_start_ns - START_NS) * 1e-9)
    return float(np.interp(arc_length, laid, profile.arc_length))


def rows(found: list[list[Found]]) -> list[Row]:
    """Return a row of the sound prints, and one for each kind of defect."""
    prints = [each for task in found for each in task]
    sound = [each for each in prints if each.kind is None]
    kinds = sorted({defect.kind.name for each in sound for defect in each.defects})
    table: list[Row] = [{
        'planted': 'nothing', 'prints': len(sound), 'unit': '',
        'found': sum(each.verdict == Verdict.FAIL for each in sound),
        'passed': sum(each.verdict == Verdict.PASS for each in sound),
        'found_from': np.nan, 'others': ' '.join(kinds)}]
    return table + [_row(kind, [each for each in prints if each.kind == kind])
                    for kind in DefectKind if any(each.kind == kind for each in prints)]


def _row(kind: DefectKind, prints: list[Found]) -> Row:
    missed = [each.size for each in prints if not each.hit]
    found = [each.size for each in prints if each.hit and each.size > max(missed, default=0.0)]
    others = sorted({defect.kind.name for each in prints for defect in each.defects
                     if defect.kind != kind})
    length = LARGEST[kind] < 0.1
    return {'planted': kind.name.lower(), 'prints': len(prints), 'unit': 'mm' if length else '%',
            'found': sum(each.hit for each in prints),
            'passed': sum(each.verdict == Verdict.PASS for each in prints),
            'found_from': min(found, default=np.nan) * (1e3 if length else 1e2),
            'others': ' '.join(others)}


VERDICTS = Study('Verdicts on sound prints, and on prints with one defect', tasks, work, rows,
                 seeds=20, processes=2)
