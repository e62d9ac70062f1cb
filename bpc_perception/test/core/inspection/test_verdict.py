"""The verdict on strokes, layers and a print, from profiles that can be checked by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from design_builders import path_of, printed, profile_along, stroke_of
import numpy as np
from perception_builders import profile_of
import pytest

from bpc_perception.core.config import ToleranceConfig
from bpc_perception.core.design.comparison import compare_with_design, WantedDesign
from bpc_perception.core.design.design import Design
from bpc_perception.core.design.registration import place_at, Registration
from bpc_perception.core.inspection.defects import DefectKind
from bpc_perception.core.inspection.verdict import judge, PrintVerdict, Verdict
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets

TARGET = WidthTargets.constant(2e-3)
PASS, FAIL, NOT_ENOUGH_SEEN = Verdict.PASS, Verdict.FAIL, Verdict.NOT_ENOUGH_SEEN


def two_strokes() -> ThicknessProfile:
    """20 mm in layer 0, 10 mm of travel, 20 mm in layer 1."""
    stroke = np.repeat((1, 0, 2), (100, 50, 100))
    status = np.where(stroke == 0, Status.BARE, Status.MEASURED).astype(np.uint8)
    profile = profile_of(np.where(stroke > 0, 2e-3, np.nan).tolist(), status.tolist(),
                         spacing=2e-4, extruding=(stroke > 0).tolist())
    return replace(profile, stroke=stroke.astype(np.intp),
                   layer=np.repeat((0, -1, 1), (100, 50, 100)))


def changed(first: int, last: int, **values: float) -> ThicknessProfile:
    """The two strokes with other values from a sample to another, exclusively."""
    profile = two_strokes()
    arrays = {name: getattr(profile, name).copy() for name in values}
    for name, value in values.items():
        arrays[name][first:last] = value
    return replace(profile, **arrays)


def said(profile: ThicknessProfile, ended: bool = True, targets: WidthTargets | None = TARGET,
         **tolerance: Any) -> tuple[Verdict, list[Verdict], list[Verdict]]:
    found = judge(profile, targets, ToleranceConfig(**tolerance), ended)
    return (found.verdict, [each.verdict for each in found.strokes],
            [each.verdict for each in found.layers])


def test_a_good_print_passes_once_it_has_ended() -> None:
    assert said(two_strokes()) == (PASS, [PASS, PASS], [PASS, PASS])
    # The stroke that is being laid may still go wrong.
    assert said(two_strokes(), ended=False) == (
        NOT_ENOUGH_SEEN, [PASS, NOT_ENOUGH_SEEN], [PASS, NOT_ENOUGH_SEEN])


def test_a_defect_fails_its_stroke_its_layer_and_the_print_at_once() -> None:
    thin = changed(40, 60, thickness=1.5e-3)
    for ended in (True, False):
        assert said(thin, ended)[0] == FAIL
    assert said(thin) == (FAIL, [FAIL, PASS], [FAIL, PASS])


def test_ooze_fails_the_layer_before_and_no_stroke() -> None:
    assert said(changed(120, 140, status=Status.OOZE)) == (FAIL, [PASS, PASS], [FAIL, PASS])


def test_a_stroke_of_which_too_little_is_seen_does_not_pass() -> None:
    hidden = changed(160, 190, status=Status.OCCLUDED, thickness=np.nan, sigma=np.nan)
    assert said(hidden) == (NOT_ENOUGH_SEEN, [PASS, NOT_ENOUGH_SEEN], [PASS, NOT_ENOUGH_SEEN])
    assert said(hidden, coverage=0.6)[0] == PASS


def test_crossings_have_no_width_and_do_not_count() -> None:
    assert said(changed(160, 190, status=Status.JUNCTION, thickness=np.nan, sigma=np.nan))[0] == (
        PASS)


def test_where_lines_touch_all_along_nothing_passes() -> None:
    """Infill that merges has no widths, however much ink was laid."""
    for last in (250, 230):
        merged = changed(150, last, status=Status.JUNCTION, thickness=np.nan, sigma=np.nan)
        assert said(merged) == (NOT_ENOUGH_SEEN, [PASS, NOT_ENOUGH_SEEN],
                                [PASS, NOT_ENOUGH_SEEN])


def test_a_stroke_too_short_to_be_judged_does_not_pass() -> None:
    dot = profile_of([6e-3] * 20, spacing=2e-4)  # 4 mm, of which 2 at each end
    assert said(dot)[0] == NOT_ENOUGH_SEEN
    assert said(dot, ends=0.0)[0] == FAIL
    assert said(dot, targets=None, offset=0.0, neck=0.0)[0] == PASS  # gaps alone are looked for


def test_what_was_being_laid_at_the_last_capture_is_no_end() -> None:
    going_on = judge(two_strokes(), TARGET, ToleranceConfig(), False, laying=True)
    assert going_on.at_its_end() == going_on
    assert going_on.verdict == NOT_ENOUGH_SEEN


def test_ooze_fails_the_print_whatever_layer_it_counts_to() -> None:
    """Of a stroke that rises, the last sample is in another layer than most."""
    profile = changed(120, 140, status=Status.OOZE)
    layer = profile.layer.copy()
    layer[95:100] = 7
    assert said(replace(profile, layer=layer))[0] == FAIL


def test_a_print_of_many_strokes_is_judged_as_fast() -> None:
    """Each stroke looks at its own samples: 20 000 strokes of ten would take minutes else."""
    count = 20_000
    stroke = np.repeat(np.arange(1, count + 1), 10)
    profile = replace(profile_of([2e-3] * len(stroke), spacing=2e-4), stroke=stroke)
    assert len(judge(profile, TARGET, ToleranceConfig(), True).strokes) == count


def test_where_heights_are_wanted_they_have_to_be_known() -> None:
    assert said(two_strokes(), target_height=0.6e-3)[0] == NOT_ENOUGH_SEEN
    heights = changed(0, 250, height=0.6e-3, height_sigma=1e-5)
    assert said(heights, target_height=0.6e-3)[0] == PASS


def test_what_was_not_looked_for_is_told() -> None:
    found = judge(two_strokes(), None, ToleranceConfig(neck=0.0), True)
    assert set(DefectKind) - found.judged == {
        DefectKind.THIN, DefectKind.THICK, DefectKind.LOW, DefectKind.HIGH, DefectKind.NECK,
        DefectKind.OFF_DESIGN, DefectKind.SKIPPED}


def test_where_nothing_is_looked_for_nothing_passes() -> None:
    assert said(two_strokes(), targets=None, offset=0.0, gap_length=0.0, neck=0.0,
                ooze_length=0.0, missing_strokes=False)[0] == NOT_ENOUGH_SEEN


def test_of_nothing_there_is_not_enough() -> None:
    assert said(profile_of([])) == (NOT_ENOUGH_SEEN, [], [])
    assert PrintVerdict.none(5).print_id == ''


@pytest.mark.parametrize('profile', [
    two_strokes(), changed(40, 60, thickness=1.5e-3),
    changed(160, 190, status=Status.OCCLUDED, thickness=np.nan, sigma=np.nan)])
def test_a_print_that_ended_later_is_judged_as_one_that_had(profile: ThicknessProfile) -> None:
    later = judge(profile, TARGET, ToleranceConfig(), False).at_its_end()
    assert later == judge(profile, TARGET, ToleranceConfig(), True)


LINES = Design((stroke_of(((0, 0, 0), (20, 0, 0)), width=1.0),
                stroke_of(((0, 5, 0), (20, 5, 0)), width=1.0),
                stroke_of(((0, 9, 0), (20, 9, 0)), width=1.0)))


def beside(left_out: tuple[int, ...] = (), left: float = 0.0, finished: bool = True,
           told: bool = True, **tolerance: Any) -> PrintVerdict:
    """Three lines, of which some are left out, so far to the left of their design [m]."""
    points, stroke = printed(LINES, left_out=left_out)
    profile = profile_along(points, stroke, left=left)
    place = place_at(0, 0, 0, 0) if told else Registration(np.full((4, 4), np.nan), refusal='no')
    found = compare_with_design(profile, WantedDesign('lines.csv', LINES, place),
                                path_of(points, stroke, finished))
    targets = found.targets(profile.arc_length, None)
    return judge(profile, targets, ToleranceConfig(**tolerance), finished, design=found)


def test_a_print_as_designed_is_judged_by_the_widths_of_its_design() -> None:
    found = beside()
    assert found.verdict == PASS
    assert {DefectKind.THIN, DefectKind.OFF_DESIGN, DefectKind.SKIPPED} <= found.judged


def test_a_stroke_that_is_skipped_fails_its_layer_and_the_print_as_soon_as_it_is_known() -> None:
    for finished in (True, False):
        found = beside(left_out=(1,), finished=finished)
        defect, = found.defects
        assert (defect.kind, defect.stroke, defect.layer) == (DefectKind.SKIPPED, 2, 0)
        assert defect.worst == pytest.approx(20e-3)
        assert defect.middle == pytest.approx((10e-3, 5e-3, 0), abs=2e-4)
        assert (found.verdict, found.layers[0].verdict) == (FAIL, FAIL)
        assert found.strokes[0].verdict == PASS
    assert beside(left_out=(1,), missing_strokes=False).verdict == PASS


def test_what_comes_before_a_recording_that_begins_with_ink_is_not_known() -> None:
    found = beside(left_out=(0,))
    assert (found.verdict, found.defects) == (NOT_ENOUGH_SEEN, ())
    assert [each.verdict for each in found.strokes] == [PASS, PASS]


def test_strokes_that_are_to_come_are_no_defect_until_the_end() -> None:
    going_on = beside(left_out=(2,), finished=False)
    assert (going_on.verdict, going_on.defects) == (NOT_ENOUGH_SEEN, ())
    points, stroke = printed(LINES, left_out=(2,))
    found = compare_with_design(profile_along(points, stroke), WantedDesign(
        'lines.csv', LINES, place_at(0, 0, 0, 0)), path_of(points, stroke, False))
    ended = going_on.at_its_end(found.findings)
    assert (ended.verdict, [each.kind for each in ended.defects]) == (FAIL, [DefectKind.SKIPPED])


def test_a_bead_beside_its_design_is_told() -> None:
    found = beside(left=0.3e-3, offset=0.25)
    assert {each.kind for each in found.defects} == {DefectKind.OFF_PATH, DefectKind.OFF_DESIGN}
    worst, = {round(each.worst, 6) for each in found.defects}
    assert worst == pytest.approx(0.3e-3)
    assert beside(left=0.3e-3, offset=0.35).verdict == PASS


def test_a_print_whose_design_lies_nowhere_cannot_pass() -> None:
    found = beside(told=False)
    assert (found.verdict, found.defects) == (NOT_ENOUGH_SEEN, ())
    assert DefectKind.SKIPPED not in found.judged
