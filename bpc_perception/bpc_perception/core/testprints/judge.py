"""Judge a test print by its profile."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.design.design import DesignError
from bpc_perception.core.design.registration import register, Registration
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.testprints.finding import Finding
from bpc_perception.core.testprints.flat_judge import judge_fusion, judge_turns
from bpc_perception.core.testprints.lag import STATE_PERIOD_S
from bpc_perception.core.testprints.matching import match
from bpc_perception.core.testprints.plan import TestPrint
from bpc_perception.core.testprints.stacked_judge import (
    judge_lattice,
    judge_line_over_lines,
    judge_wall,
)
from bpc_perception.core.testprints.sweep_judge import judge_sweep, SweepResult


@dataclass(frozen=True)
class Judgement:
    """What a test print tells.

    Attributes:
        findings: of the print first.
        missing: numbers of the planned strokes that were not printed, from 1.
        sweep: of lines; None = it is another test print.
    """

    findings: list[Finding]
    missing: list[int] = field(default_factory=list)
    sweep: SweepResult | None = None


def judge(test: TestPrint, profile: ThicknessProfile, place: Registration | None = None,
          cloud: Array | None = None, period: float = STATE_PERIOD_S) -> Judgement:
    """Return what a test print tells.

    Args:
        test: as it was planned.
        profile: of its recording.
        place: where its design lies; None = it is found by the path.
        cloud: (M, 3) points of the last capture in the base frame [m]; None = not at hand.
        period: time between states of the extruder [s].

    Raises:
        DesignError: where the test print lies is not found; the message says why.
    """
    place = place or register(test.design, profile.points, profile.stroke, finished=True)
    if place.refusal:
        raise DesignError(place.refusal)
    matched = match(test, profile, place)
    missing = sorted(set(range(len(test.plans))) - set(np.unique(matched.stroke).tolist()))
    numbers = [index + 1 for index in missing]
    if test.name == 'lines':
        sweep = judge_sweep(matched, period)
        return Judgement(sweep.findings, numbers, sweep)
    if test.name == 'line-over-lines':
        return Judgement(judge_line_over_lines(matched, cloud), numbers)
    judged = {'fusion': judge_fusion, 'turns': judge_turns, 'lattice': judge_lattice,
              'wall': judge_wall}[test.name]
    return Judgement(judged(matched), numbers)
