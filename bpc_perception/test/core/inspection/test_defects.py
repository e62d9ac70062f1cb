"""Which stretches of a print are defects, by profiles that can be checked by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from perception_builders import profile_of
import pytest

from bpc_perception.core.config import ToleranceConfig
from bpc_perception.core.inspection.defects import Defect, DefectKind
from bpc_perception.core.inspection.verdict import judge
from bpc_perception.core.profile import Cause, Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets

TARGET = WidthTargets.constant(2e-3)
SPACING = 2e-4
COUNT = 200  # 40 mm


def even(**others: Any) -> ThicknessProfile:
    """A stroke of 2 mm of width all along, every 0.2 mm."""
    return replace(profile_of([2e-3] * COUNT, spacing=SPACING), **others)


def with_widths(first: int, last: int, width: float) -> ThicknessProfile:
    """The same with another width from a sample to another, exclusively."""
    thickness = even().thickness.copy()
    thickness[first:last] = width
    return even(thickness=thickness, left=thickness / 2, right=thickness / 2)


def find_defects(profile: ThicknessProfile, targets: WidthTargets | None,
                 tolerance: ToleranceConfig) -> tuple[Defect, ...]:
    return judge(profile, targets, tolerance, True).defects


def kinds(profile: ThicknessProfile, targets: WidthTargets | None = TARGET,
          **tolerance: Any) -> list[DefectKind]:
    return [each.kind for each in find_defects(profile, targets, ToleranceConfig(**tolerance))]


def test_an_even_print_has_none() -> None:
    assert kinds(even()) == []
    assert kinds(profile_of([])) == []


@pytest.mark.parametrize(('width', 'kind', 'limit'), [
    (1.6e-3, DefectKind.THIN, 1.7e-3), (2.4e-3, DefectKind.THICK, 2.3e-3)])
def test_a_width_out_of_its_band_is_told_from_where_to_where(
        width: float, kind: DefectKind, limit: float) -> None:
    defect, = find_defects(with_widths(100, 110, width), TARGET, ToleranceConfig())
    assert defect.kind == kind
    assert (defect.start, defect.end) == pytest.approx((100 * SPACING, 109 * SPACING))
    assert (defect.worst, defect.limit) == pytest.approx((width, limit))
    assert (defect.stroke, defect.layer, defect.samples) == (1, 0, 10)


def test_fewer_samples_in_a_row_are_none() -> None:
    assert kinds(with_widths(100, 104, 1.6e-3)) == []
    assert kinds(with_widths(100, 105, 1.6e-3)) == [DefectKind.THIN]
    assert kinds(with_widths(100, 104, 1.6e-3), samples=4) == [DefectKind.THIN]


def test_where_it_is_not_sure_there_is_none() -> None:
    doubtful = replace(with_widths(100, 120, 1.6e-3), sigma=np.full(COUNT, 0.06e-3))
    assert kinds(doubtful) == []
    assert kinds(replace(doubtful, sigma=np.full(COUNT, 0.04e-3))) == [DefectKind.THIN]


def test_without_a_target_widths_are_not_judged_but_necks_are() -> None:
    assert kinds(with_widths(100, 110, 1.6e-3), None) == []
    assert kinds(with_widths(100, 110, 1.3e-3), None) == [DefectKind.NECK]
    assert kinds(with_widths(100, 110, 1.3e-3)) == [DefectKind.THIN]  # not both


def test_a_neck_is_found_though_some_of_it_is_not_known() -> None:
    thickness = with_widths(100, 110, 1.2e-3).thickness.copy()
    status = even().status.copy()
    for unknown in (101, 102, 104, 105, 106, 108):
        thickness[unknown], status[unknown] = np.nan, Status.LOW_CONFIDENCE
    profile = even(thickness=thickness, status=status)
    assert kinds(profile, None) == [DefectKind.NECK]
    assert kinds(profile, None, samples=11) == []


def test_a_steep_neck_of_which_only_the_middle_is_known_is_found() -> None:
    thickness = with_widths(100, 112, 1.2e-3).thickness.copy()
    status = even().status.copy()
    steep = np.r_[100:105, 107:112]
    thickness[steep], status[steep] = np.nan, Status.LOW_CONFIDENCE
    assert kinds(even(thickness=thickness, status=status), None) == [DefectKind.NECK]
    status[steep] = Status.OCCLUDED  # what is hidden is no sign of a neck
    assert kinds(even(thickness=thickness, status=status), None) == []


def test_the_ends_of_a_stroke_are_not_judged_by_width() -> None:
    assert kinds(with_widths(0, 10, 3e-3)) == []
    assert kinds(with_widths(0, 10, 3e-3), ends=0.0) == [DefectKind.THICK]


@pytest.mark.parametrize(('height', 'kind'), [(0.3e-3, DefectKind.LOW), (1e-3, DefectKind.HIGH)])
def test_a_height_out_of_its_band_is_told_where_one_is_wanted(height: float,
                                                             kind: DefectKind) -> None:
    heights = np.full(COUNT, 0.6e-3)
    heights[100:110] = height
    profile = even(height=heights, height_sigma=np.full(COUNT, 1e-5))
    assert kinds(profile) == []
    assert kinds(profile, target_height=0.6e-3) == [kind]


@pytest.mark.parametrize('side', [1, -1])
def test_a_bead_beside_its_path_is_off_path(side: int) -> None:
    offset = np.zeros(COUNT)
    offset[100:110] = side * 0.6e-3
    profile = even(left=1e-3 + offset, right=1e-3 - offset)
    defect, = find_defects(profile, TARGET, ToleranceConfig())
    assert defect.kind == DefectKind.OFF_PATH
    assert (defect.worst, defect.limit) == pytest.approx((side * 0.6e-3, side * 0.5e-3))


def far_beside(shift: float) -> ThicknessProfile:
    """Ink so far beside its path that no width is told."""
    unknown = np.full(COUNT, np.nan)
    return even(status=np.full(COUNT, Status.LOW_CONFIDENCE, np.uint8), thickness=unknown,
                sigma=unknown, left=unknown, right=unknown,
                cause=np.full(COUNT, Cause.OFF_PATH, np.uint8), shift=np.array((0.0, shift, 0.0)))


def test_ink_so_far_beside_its_path_that_no_width_is_told_is_off_path() -> None:
    defect, = find_defects(far_beside(1.5e-3), TARGET, ToleranceConfig())
    assert (defect.kind, defect.worst) == (DefectKind.OFF_PATH, 1.5e-3)


def gap(first: int, last: int, count: int = COUNT) -> ThicknessProfile:
    status = np.zeros(count, np.uint8)
    status[first:last] = Status.GAP
    return profile_of(np.where(status == Status.GAP, 0.0, 2e-3).tolist(), status.tolist(),
                      spacing=SPACING, speed=1e-3)


def test_a_gap_longer_than_allowed_is_told_with_its_length() -> None:
    assert kinds(gap(100, 109)) == []
    defect, = find_defects(gap(100, 112), TARGET, ToleranceConfig())
    assert defect.kind == DefectKind.GAP
    assert (defect.worst, defect.limit) == pytest.approx((12 * SPACING, 2e-3))


def test_a_stroke_without_ink_is_missing_and_no_gap() -> None:
    defect, = find_defects(gap(0, 100, 100), TARGET, ToleranceConfig())
    assert (defect.kind, defect.stroke) == (DefectKind.MISSING_STROKE, 1)
    assert defect.worst == pytest.approx(99 * SPACING)


def oozing() -> ThicknessProfile:
    """20 mm of a stroke in layer 3, and 20 mm of travel with 4 mm of ink."""
    stroke = np.where(np.arange(COUNT) < 100, 1, 0)
    status = np.where(stroke > 0, Status.MEASURED, Status.BARE).astype(np.uint8)
    status[150:170] = Status.OOZE
    return even(stroke=stroke, status=status, layer=np.where(stroke > 0, 3, -1),
                thickness=np.where(stroke > 0, 2e-3, np.nan), extruding=stroke > 0)


def test_ooze_on_travel_counts_to_the_layer_before() -> None:
    defect, = find_defects(oozing(), TARGET, ToleranceConfig())
    assert (defect.kind, defect.stroke, defect.layer) == (DefectKind.OOZE, 0, 3)
    assert defect.worst == pytest.approx(20 * SPACING)


def test_ink_that_is_late_leaves_no_missing_stroke() -> None:
    assert kinds(gap(0, 8, 8)) == []


def test_samples_far_apart_are_in_a_row_as_well() -> None:
    coarse = profile_of([2e-3] * 20 + [1e-3] * 10 + [2e-3] * 20, spacing=3e-3)
    assert kinds(coarse) == [DefectKind.THIN]


def test_a_shift_that_is_allowed_is_no_defect() -> None:
    assert kinds(far_beside(0.4e-3)) == []
    assert kinds(far_beside(1.5e-3), offset=1.0) == []
    assert kinds(far_beside(1.5e-3), None, offset=1.0) == [DefectKind.OFF_PATH]


@pytest.mark.parametrize(('profile', 'switch'), [
    (with_widths(100, 110, 1.6e-3), {'width': 0.0}), (gap(100, 120), {'gap_length': 0.0}),
    (gap(0, 100, 100), {'missing_strokes': False, 'gap_length': 0.0}),
    (far_beside(1.5e-3), {'offset': 0.0}), (oozing(), {'ooze_length': 0.0})])
def test_each_check_can_be_switched_off(profile: ThicknessProfile, switch: Any) -> None:
    assert kinds(profile) != []
    assert kinds(profile, **switch) == []
