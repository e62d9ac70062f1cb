"""How far prints are from their design, where that is known."""

from __future__ import annotations

from dataclasses import replace

from design_builders import lattice, MM, path_of, printed, profile_along, stroke_of
import numpy as np
from perception_builders import pose
import pytest

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.design.design import Design
from bpc_perception.core.design.deviation import Deviations, deviations_of, placed, Spread
from bpc_perception.core.design.layer_fidelity import LayerFidelity, layers_of
from bpc_perception.core.design.presence import Missing, missing_in, Presence, presence_of
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile

LINES = Design((stroke_of(((0, 0, 0.3), (20, 0, 0.3)), width=0.8),
                stroke_of(((20, 5, 0.3), (0, 5, 0.3)), width=1.2)))


def compared(design: Design, profile: ThicknessProfile, path: DepositionPath | None = None,
             T_base_design: Array | None = None,
             ) -> tuple[Deviations, Index, tuple[LayerFidelity, ...], tuple[Missing, ...]]:
    pieces, up = placed(design, np.eye(4) if T_base_design is None else T_base_design)
    deviations = deviations_of(profile, pieces, up)
    presence = presence_of(profile, path or path_of(profile.points, profile.stroke), pieces,
                           deviations)
    return (deviations, presence, layers_of(pieces, deviations, presence, up),
            missing_in(pieces, presence))


def test_a_print_as_designed() -> None:
    points, stroke = printed(LINES)
    deviations, presence, (layer,), missing = compared(LINES, profile_along(points, stroke))
    laid = stroke > 0
    assert np.abs(deviations.nozzle[laid]).max() < 1e-9
    assert np.abs(deviations.bead[laid]).max() < 1e-9
    assert np.isnan(deviations.nozzle[~laid]).all()
    assert np.isnan(deviations.width[~laid]).all()
    assert (deviations.layer == np.where(laid, 0, -1)).all()
    assert deviations.width[stroke == 1] == pytest.approx(0.8 * MM)
    assert deviations.width[stroke == 2] == pytest.approx(1.2 * MM)
    assert not deviations.surplus.any()
    assert (presence == Presence.PRINTED).all()
    assert missing == ()
    assert (layer.layer, layer.fidelity, layer.known, layer.designed) == (0, 1.0, 200, 200)
    assert layer.hausdorff <= 0.1 * MM + 1e-9  # pieces lie between samples
    assert layer.to_print.count == 200
    assert layer.to_design.count == laid.sum()


@pytest.mark.parametrize('place', [pose(), pose((0.3, 0.1, 0.5), (130, 2, -3))])
def test_left_is_left_of_the_way_the_design_runs(place: Array) -> None:
    """Both lines are printed 0.3 mm towards +y: left of the first, right of the second."""
    points, stroke = printed(LINES)
    moved = np.add(points, (0, 0.3 * MM, 0))
    profile = profile_along(moved, stroke, left=0.1 * MM)
    T_base = place[:3, :3]
    profile = replace(profile, **{name: getattr(profile, name) @ T_base.T + place[:3, 3]
                                  for name in ('points', 'left_points', 'right_points')})
    deviations, _, (layer,), _ = compared(LINES, profile, T_base_design=place)
    inner = np.abs(points[:, 0] - 10 * MM) < 8 * MM
    one, two = (stroke == 1) & inner, (stroke == 2) & inner
    assert deviations.nozzle[one] == pytest.approx(0.3 * MM)
    assert deviations.nozzle[two] == pytest.approx(-0.3 * MM)
    assert deviations.bead[one] == pytest.approx(0.4 * MM)
    assert deviations.bead[two] == pytest.approx(-0.2 * MM)
    assert layer.to_design.most == pytest.approx(0.4 * MM, abs=1e-6)
    assert layer.to_design.mean == pytest.approx(0.3 * MM, rel=0.02)
    assert layer.fidelity == 1.0


def test_what_is_farther_than_delta_does_not_match() -> None:
    points, stroke = printed(LINES)
    profile = profile_along(points, stroke, left=np.where(stroke == 1, 0.6 * MM, 0.0))
    _, _, (layer,), _ = compared(LINES, profile)
    assert layer.fidelity == pytest.approx(0.5)
    assert layer.hausdorff == pytest.approx(0.6 * MM, rel=0.05)
    assert layer.to_design.most_of_95 == pytest.approx(0.6 * MM)


def test_what_is_not_measured_has_no_deviation_of_the_bead() -> None:
    points, stroke = printed(LINES)
    profile = profile_along(points, stroke)
    status = profile.status.copy()
    status[stroke == 2] = Status.OCCLUDED
    deviations, _, (layer,), missing = compared(LINES, replace(profile, status=status))
    assert np.isfinite(deviations.nozzle[stroke == 2]).all()
    assert np.isnan(deviations.bead[stroke == 2]).all()
    assert (layer.fidelity, layer.known, layer.designed) == (1.0, 100, 200)
    assert [(part.stroke, part.presence) for part in missing] == [(1, Presence.NOT_SEEN)]
    assert missing[0].end - missing[0].start == pytest.approx(20 * MM)
    assert missing[0].count == 100


def test_a_gap_is_seen_missing() -> None:
    points, stroke = printed(LINES)
    profile = profile_along(points, stroke)
    gap = (stroke == 1) & (points[:, 0] > 5.01 * MM) & (points[:, 0] < 8.99 * MM)
    status = np.where(gap, Status.GAP, profile.status).astype(np.uint8)
    _, _, (layer,), missing = compared(LINES, replace(profile, status=status))
    part, = missing
    assert (part.stroke, part.presence) == (0, Presence.SEEN_MISSING)
    assert (part.start, part.end) == (pytest.approx(5 * MM, abs=0.21 * MM),
                                      pytest.approx(9 * MM, abs=0.21 * MM))
    # 4 mm of 40, of which 0.5 mm at either end are near enough to ink.
    assert layer.fidelity == pytest.approx(1 - 3 / 40, abs=0.01)
    assert layer.known == 200
    assert layer.to_print.most == pytest.approx(2 * MM, abs=0.2 * MM)


@pytest.mark.parametrize(('finished', 'presence'), [
    (False, Presence.YET_TO_COME), (True, Presence.SKIPPED)])
def test_what_is_yet_to_come_is_not_missing(finished: bool, presence: Presence) -> None:
    points, stroke = printed(LINES, until=30 * MM)
    profile = profile_along(points, stroke)
    _, _, (layer,), missing = compared(LINES, profile, path_of(points, stroke, finished))
    part, = missing
    assert (part.stroke, part.presence) == (1, presence)
    assert part.start == pytest.approx(10 * MM, abs=1.1 * MM)
    assert part.end == pytest.approx(20 * MM)
    assert layer.fidelity == pytest.approx(0.76 if finished else 1.0, abs=0.03)


def test_what_the_print_left_out_is_skipped() -> None:
    points, stroke = printed(lattice(), left_out=(4,))
    _, _, _, missing = compared(lattice(), profile_along(points, stroke),
                                path_of(points, stroke, finished=False))
    assert [(part.stroke, part.presence, part.layer) for part in missing] == [
        (4, Presence.SKIPPED, 0)]


def test_where_the_path_went_beyond_the_profile_ink_is_not_seen_yet() -> None:
    points, stroke = printed(LINES)
    profile = profile_along(points[stroke == 1], stroke[stroke == 1])
    _, _, (layer,), missing = compared(LINES, profile, path_of(points, stroke, finished=False))
    assert [(part.stroke, part.presence) for part in missing] == [(1, Presence.NOT_SEEN)]
    assert layer.known == 100


def test_ink_where_no_design_is_is_surplus() -> None:
    more = Design((stroke_of(((0, 15, 0.3), (10, 15, 0.3))), *LINES.strokes))
    points, stroke = printed(more)
    profile = profile_along(points, stroke)
    deviations, presence, (layer,), missing = compared(LINES, profile)
    np.testing.assert_array_equal(deviations.surplus, stroke == 1)
    (start, end), = profile.runs_of(deviations.surplus)
    assert end - start == pytest.approx(10 * MM, abs=1e-6)
    assert np.isnan(deviations.nozzle[stroke == 1]).all()
    assert missing == ()
    assert (presence == Presence.PRINTED).all()
    assert layer.to_design.most == pytest.approx(10 * MM, rel=0.01)
    assert layer.hausdorff == layer.to_design.most


def test_corners_beside_other_strokes_are_on_the_design() -> None:
    """Where it turns back the path seems to run as the layer above does."""
    design = Design((stroke_of(((0, 0, 0.3), (10, 0, 0.3), (1, 0.5, 0.3))),
                     stroke_of(((9.8, -5, 0.4), (9.8, 5, 0.4)), layer=1)))
    points, stroke = printed(design)
    deviations, _, _, missing = compared(design, profile_along(points, stroke))
    assert np.abs(deviations.nozzle[stroke > 0]).max() < 1e-6
    assert missing == ()


def test_layers_are_told_apart_by_height() -> None:
    design = lattice(lines=4, layers=3)
    points, stroke = printed(design)
    shift = np.where(points[:, 2] > 0.5 * MM, 0.2 * MM, 0.0)  # of the third layer
    _, _, layers, missing = compared(design, profile_along(points, stroke, left=shift))
    assert [layer.layer for layer in layers] == [0, 1, 2]
    assert missing == ()
    assert [layer.to_design.mean for layer in layers] == pytest.approx((0, 0, 0.2 * MM),
                                                                       abs=0.01 * MM)


def test_without_any_print_nothing_is_known() -> None:
    profile = ThicknessProfile.none(0)
    deviations, presence, (layer,), missing = compared(
        LINES, profile, path_of(np.zeros((0, 3)), np.zeros(0, int), finished=False))
    assert len(deviations.nozzle) == 0
    assert (presence == Presence.YET_TO_COME).all()
    assert len(missing) == 2
    assert np.isnan(layer.fidelity)
    assert np.isnan(layer.hausdorff)
    assert (layer.known, layer.to_print.count, layer.to_design.count) == (0, 0, 0)


def test_spreads_leave_out_what_is_not_known() -> None:
    spread = Spread.of(np.array((-3.0, np.nan, 1.0)))
    assert (spread.count, spread.mean, spread.most) == (2, -1.0, 3.0)
    assert spread.rms == pytest.approx(5**0.5)
    assert Spread.of(np.full(3, np.nan)).count == 0
    assert np.isnan(Spread.of(np.empty(0)).rms)
