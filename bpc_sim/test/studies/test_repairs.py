"""What is proposed to mend simulated prints, whose gaps lie where they were planted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.config import RepairConfig, ToleranceConfig
from bpc_perception.core.geometry import invert, transform
from bpc_perception.core.inspection.defects import DefectKind
from bpc_perception.core.inspection.verdict import judge
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.repair.plan import FillKind, NextLayer, Obstacle, RepairPlan
from bpc_perception.core.repair.planner import plan_repair
from bpc_perception.core.targets import WidthTargets
from bpc_sim.printer.scenarios import spiral_gaps
from bpc_sim.studies.verdicts.planted import planted, sound_print, WIDTH_M
from bpc_sim.studies.verdicts.study import along, measured

SPACING_M = 2e-4
SPEED_M_PER_S = 0.01


def plan(profile: ThicknessProfile, width: float | None = WIDTH_M) -> RepairPlan:
    targets = None if width is None else WidthTargets.constant(width)
    tolerance = ToleranceConfig()
    verdict = judge(profile, targets, tolerance, True)
    return plan_repair(profile, verdict, Reason.ON_TARGET, targets, tolerance, RepairConfig())


@pytest.mark.parametrize(('size', 'number'), [(3e-3, 1), (4e-3, 2), (6e-3, 3)])
def test_a_planted_gap_is_covered_within_a_sample_on_the_way_of_the_nozzle(size: float,
                                                                           number: int) -> None:
    print_ = planted(DefectKind.GAP, size, number)
    profile = measured(print_.job)
    found = plan(profile)
    fill, = found.fills
    start, end = (along(print_.job, profile, at) for at in print_.extent)
    # All of it lies below the way, which reaches half a width onto the ink.
    assert fill.arc_length[0] < start < end < fill.arc_length[-1]
    assert fill.arc_length[0] > start - WIDTH_M
    assert fill.arc_length[-1] < end + WIDTH_M
    # Half a spacing from the sample, and as much from where its ink is counted.
    assert (fill.start, fill.end) == pytest.approx((start, end), abs=1.5 * SPACING_M)
    commanded = print_.job.commanded
    np.testing.assert_allclose(  # in the line, seen on the bed: y and z do not change
        np.ptp(transform(invert(print_.job.T_base_surface), fill.points)[:, 1:], axis=0), 0.0,
        atol=2e-5)
    assert fill.speed == pytest.approx(SPEED_M_PER_S, rel=1e-3)
    # The extruder pushes a round filament of the width.
    wanted = np.pi / 4 * commanded.width(np.array([sum(print_.extent) / 2]))[0]**2
    assert fill.volume == pytest.approx(wanted * (fill.end - fill.start), rel=0.02)
    layer, = found.layers
    assert (layer.state.next_layer, layer.state.obstacles) == (NextLayer.NO, (Obstacle.GAP,))


def test_the_fault_of_the_sample_print_is_filled_and_its_planned_gaps_are_not() -> None:
    job = spiral_gaps(SPEED_M_PER_S)
    profile = measured(job)
    fill, = plan(profile).fills
    start, end = (along(job, profile, at) for at in job.faults[0])
    assert fill.kind == FillKind.GAP
    assert fill.arc_length[0] < start < end < fill.arc_length[-1]
    assert (fill.start, fill.end) == pytest.approx((start, end), abs=1.5 * SPACING_M)


@pytest.mark.parametrize('number', [1, 3, 6, 7])  # a ring, strokes, a stack, crossed layers
def test_sound_prints_are_left_alone(number: int) -> None:
    found = plan(measured(sound_print(number)), width=None)
    assert found.fills == ()
    assert NextLayer.NO not in [each.state.next_layer for each in found.layers]


def test_a_gap_that_is_half_hidden_is_left_alone() -> None:
    print_ = planted(DefectKind.GAP, 6e-3, 3)
    profile = measured(print_.job)
    start, end = (along(print_.job, profile, at) for at in print_.extent)
    hidden = (profile.arc_length > (start + end) / 2) & (profile.arc_length < end + 2e-3)
    status = np.where(hidden, Status.OCCLUDED, profile.status).astype(np.uint8)
    found = plan(replace(profile, status=status))
    assert found.fills == ()
    assert len(found.layers[0].unfilled) == 1


def test_a_thin_stretch_gets_what_it_lacks() -> None:
    print_ = planted(DefectKind.THIN, 0.3, 3)
    profile = measured(print_.job)
    fill, = plan(profile).fills
    start, end = (along(print_.job, profile, at) for at in print_.extent)
    assert fill.kind == FillKind.THIN
    assert start - 3e-4 < fill.start < fill.end < end + 3e-4
    # Its cross-section is a segment of the same shape: 0.7^2 of the ink is there.
    commanded = np.pi / 4 * WIDTH_M**2
    middle = (fill.arc_length > start + 1e-3) & (fill.arc_length < end - 2e-3)
    np.testing.assert_allclose(fill.area[middle], (1 - 0.7**2) * commanded, rtol=0.15)
