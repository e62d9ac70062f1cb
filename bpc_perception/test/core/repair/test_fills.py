"""Strokes to fill, by beads whose gaps and volumes can be worked out by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from repair_builders import (
    AREA_M2,
    bead,
    COUNT,
    plan,
    SPACING_M,
    SPEED,
    TIP_M,
    WIDTH_M,
    with_gap,
    with_status,
)

from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.config import ToleranceConfig
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.repair.plan import FillKind, NotFilled

FIRST, END = 100, 120  # samples of a gap of 4 mm
BEGINS_M, ENDS_M = (FIRST - 0.5) * SPACING_M, (END - 0.5) * SPACING_M


def reasons(profile: ThicknessProfile, **others: Any) -> list[NotFilled]:
    """Why nothing is filled."""
    found = plan(profile, **others)
    assert found.fills == ()
    return [each.reason for layer in found.layers for each in layer.unfilled]


def thin(first: int = FIRST, end: int = END, width: float = 0.7, area: float = 0.5,
         **others: Any) -> ThicknessProfile:
    """A bead that is thinner on some samples, by these shares."""
    profile = bead(**others)
    own = slice(first, end)
    thickness, areas = profile.thickness.copy(), profile.area.copy()
    thickness[own], areas[own] = width * WIDTH_M, area * AREA_M2
    return replace(profile, thickness=thickness, left=thickness / 2, right=thickness / 2,
                   area=areas)


def test_a_bead_without_gaps_is_left_alone() -> None:
    found = plan(bead())
    assert found.fills == ()
    assert found.layers[0].unfilled == ()


def test_a_gap_is_filled_with_all_that_was_commanded() -> None:
    fill, = plan(with_gap(FIRST, END)).fills
    assert (fill.kind, fill.stroke, fill.layer) == (FillKind.GAP, 1, 0)
    assert (fill.start, fill.end) == pytest.approx((BEGINS_M, ENDS_M))
    assert fill.volume == pytest.approx(AREA_M2 * 4e-3)
    assert fill.speed == pytest.approx(SPEED)
    assert fill.flow.max() == pytest.approx(AREA_M2 * SPEED)


def test_the_way_is_that_of_the_nozzle_and_overlaps_the_ink_at_both_sides() -> None:
    fill, = plan(with_gap(FIRST, END)).fills
    assert fill.arc_length[[0, -1]] == pytest.approx(
        (BEGINS_M - WIDTH_M / 2, ENDS_M + WIDTH_M / 2))
    np.testing.assert_allclose(fill.points[:, 0], fill.arc_length)
    np.testing.assert_allclose(fill.points[:, 1:], 0.0)
    assert (np.diff(fill.arc_length) > 0).all()
    lies = fill.area > 0  # on the overlap nothing is lacking
    assert fill.arc_length[lies][0] == pytest.approx(BEGINS_M)
    assert fill.arc_length[1:][lies[:-1]][-1] == pytest.approx(ENDS_M)
    no_overlap, = plan(with_gap(FIRST, END), overlap=0.0).fills
    assert no_overlap.arc_length[[0, -1]] == pytest.approx((BEGINS_M, ENDS_M))


def test_doubtful_samples_at_the_end_of_ink_belong_half_to_the_gap() -> None:
    profile = with_status(with_gap(FIRST, END), Status.LOW_CONFIDENCE,
                          (FIRST - 2, FIRST), (END, END + 2))
    fill, = plan(profile).fills
    assert (fill.start, fill.end) == pytest.approx((BEGINS_M - SPACING_M, ENDS_M + SPACING_M))


@pytest.mark.parametrize('status', [Status.NO_DATA, Status.OCCLUDED, Status.JUNCTION])
def test_a_gap_whose_end_is_hidden_is_not_filled(status: Status) -> None:
    assert reasons(with_status(with_gap(FIRST, END), status, (END, END + 1))) == [
        NotFilled.END_NOT_SEEN]
    assert reasons(with_status(with_gap(FIRST, END), status, (FIRST - 1, FIRST))) == [
        NotFilled.END_NOT_SEEN]


def test_nor_one_whose_end_is_in_doubt_for_longer_than_a_width() -> None:
    gap = with_gap(FIRST, END)
    assert plan(with_status(gap, Status.LOW_CONFIDENCE, (END, END + 4))).fills
    assert reasons(with_status(gap, Status.LOW_CONFIDENCE, (END, END + 7))) == [
        NotFilled.END_NOT_SEEN]


@pytest.mark.parametrize('status', [Status.NO_DATA, Status.OCCLUDED, Status.LOW_CONFIDENCE])
def test_what_is_hidden_alone_is_no_gap(status: Status) -> None:
    assert reasons(with_status(bead(), status, (FIRST, END))) == []


def test_between_two_gaps_where_it_is_in_doubt_nothing_is_laid() -> None:
    profile = with_status(with_gap(FIRST, END + 20), Status.LOW_CONFIDENCE, (END, END + 2))
    one, other = plan(profile).fills
    assert one.arc_length[-1] == one.end == pytest.approx(ENDS_M)
    assert other.arc_length[0] == other.start == pytest.approx(ENDS_M + 2 * SPACING_M)


def test_a_gap_at_the_end_of_a_stroke_ends_there() -> None:
    fill, = plan(with_gap(COUNT - 20, COUNT)).fills
    assert fill.arc_length[-1] == fill.end == pytest.approx((COUNT - 1) * SPACING_M)


def test_the_overlap_ends_where_ink_is_not_measured() -> None:
    fill, = plan(with_status(with_gap(FIRST, END), Status.OCCLUDED, (END + 1, END + 5))).fills
    assert fill.arc_length[-1] == pytest.approx(END * SPACING_M)


def test_gaps_that_are_allowed_or_shorter_than_the_bead_is_wide_are_said() -> None:
    assert reasons(with_gap(FIRST, FIRST + 9)) == [NotFilled.ALLOWED]
    strict = ToleranceConfig(gap_length=0.0005)
    assert reasons(with_gap(FIRST, FIRST + 4), tolerance=strict) == [NotFilled.SHORT]
    assert plan(with_gap(FIRST, FIRST + 6), tolerance=strict).fills
    assert plan(with_gap(FIRST, FIRST + 4), tolerance=strict, least_length=0.5).fills


def test_without_a_target_the_width_of_the_layer_tells_what_is_short() -> None:
    fill, = plan(with_gap(FIRST, END), targets=None).fills
    assert fill.arc_length[0] == pytest.approx(BEGINS_M - WIDTH_M / 2)
    assert reasons(with_gap(0, COUNT), targets=None) == [NotFilled.WIDTH_NOT_KNOWN]


def test_without_a_flow_nothing_is_proposed() -> None:
    unknown = bead(commanded_area=np.full(COUNT, np.nan))
    assert reasons(with_gap(FIRST, END, unknown)) == [NotFilled.FLOW_NOT_KNOWN]


def test_a_flow_that_changed_along_the_gap_is_laid_as_it_was_commanded() -> None:
    commanded = np.where(np.arange(COUNT) < 110, AREA_M2, 2 * AREA_M2)
    commanded[105] = np.nan  # where the nozzle stood
    fill, = plan(with_gap(FIRST, END, bead(commanded_area=commanded))).fills
    assert fill.volume == pytest.approx(1.5 * AREA_M2 * 4e-3, rel=1e-3)


@pytest.mark.parametrize('reason', [Reason.PATH_OFFSET, Reason.EXTRUDER_FAULT])
def test_nothing_is_proposed_on_contradictory_data(reason: Reason) -> None:
    assert reasons(with_gap(FIRST, END), reason=reason) == [NotFilled.CONTRADICTION]


@pytest.mark.parametrize('delivered', [1.0, 0.25])
def test_a_thin_stretch_gets_what_it_lacks_beside_sound_ink(delivered: float) -> None:
    fill, = plan(thin(delivered=delivered)).fills
    assert fill.kind == FillKind.THIN
    assert (fill.start, fill.end) == pytest.approx((FIRST * SPACING_M, (END - 1) * SPACING_M))
    np.testing.assert_allclose(fill.area[:-1], AREA_M2 / 2 / delivered)


def test_ink_that_is_narrower_but_no_less_is_left_alone() -> None:
    assert reasons(thin(area=1.0)) == [NotFilled.ENOUGH_INK]
    unsure = thin(area=0.9, area_sigma=np.full(COUNT, 0.06 * AREA_M2))
    assert reasons(unsure) == [NotFilled.ENOUGH_INK]
    assert plan(replace(unsure, area_sigma=np.full(COUNT, 0.04 * AREA_M2))).fills


def test_a_thin_stretch_without_areas_or_without_sound_ink_is_left_alone() -> None:
    profile = thin()
    area = profile.area.copy()
    area[FIRST:END] = np.nan
    assert reasons(replace(profile, area=area)) == [NotFilled.AREA_NOT_KNOWN]
    assert reasons(thin(0, COUNT)) == [NotFilled.AREA_NOT_KNOWN]


def test_where_the_area_is_in_doubt_nothing_is_laid() -> None:
    profile = thin()
    area = profile.area.copy()
    area[108:112] = np.nan
    fill, = plan(replace(profile, area=area)).fills
    at = np.abs(fill.arc_length - 110 * SPACING_M) < 0.9 * SPACING_M
    assert (fill.area[at] == 0).all()
    assert fill.volume < 0.9 * AREA_M2 / 2 * (fill.end - fill.start)


def two_layers(beside: float) -> ThicknessProfile:
    """A bead with a gap, and another of the next layer so far beside it, as seen from above."""
    lower = with_gap(FIRST, END)
    upper = bead()
    points = upper.points + np.array((0.0, beside, 2 * TIP_M))
    arrays = {name: np.concatenate((getattr(lower, name), getattr(upper, name)))
              for name in lower.__dataclass_fields__
              if isinstance(getattr(lower, name), np.ndarray) and name != 'shift'}
    gone = lower.arc_length[-1] + 0.01
    arrays |= {
        'arc_length': np.append(lower.arc_length, upper.arc_length + gone),
        'time': np.append(lower.time, upper.time + gone / SPEED),
        'points': np.concatenate((lower.points, points)),
        'stroke': np.repeat((1, 2), COUNT), 'layer': np.repeat((0, 1), COUNT)}
    return replace(lower, **arrays)


def test_a_gap_under_higher_ink_is_not_filled() -> None:
    assert reasons(two_layers(0.0)) == [NotFilled.COVERED]
    assert reasons(two_layers(1.4e-3)) == [NotFilled.COVERED]  # 1 mm nozzle + 0.5 mm half a bead
    assert len(plan(two_layers(1.6e-3)).fills) == 1
    assert len(plan(two_layers(1.4e-3), nozzle_radius=5e-4).fills) == 1


def test_only_finished_layers_are_mended() -> None:
    going_on = plan(with_gap(FIRST, END), ended=False, laying=True)
    assert going_on.fills == ()
    assert len(going_on.layers[0].fills) == 1
    assert going_on.at_its_end().fills == ()  # its end was not seen
    paused = plan(with_gap(FIRST, END), ended=False)
    assert paused.fills == ()
    assert len(paused.at_its_end().fills) == 1
    begun = plan(two_layers(5e-3), ended=False, laying=True)
    assert [each.finished for each in begun.layers] == [True, False]
    assert len(begun.fills) == 1
