"""What test prints tell, of inks whose law is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from perception_builders import pose
import pytest
from testprint_builders import Ink, PERIOD, printed, SIGMA

from bpc_perception.core.design.design import DesignError
from bpc_perception.core.design.registration import place_at
from bpc_perception.core.profile import Cause, Status
from bpc_perception.core.testprints.flat import fusion, turns
from bpc_perception.core.testprints.judge import judge, Judgement
from bpc_perception.core.testprints.plan import Part
from bpc_perception.core.testprints.setup import round_width, Setup
from bpc_perception.core.testprints.stacked import lattice, line_over_lines, wall
from bpc_perception.core.testprints.sweep import lines

MM = 1e-3
SETUP = Setup(0.41 * MM, (60 * MM, 60 * MM))
SWEEP = lines(SETUP, [0.2e-9, 0.4e-9], [2 * MM, 4 * MM, 6 * MM])
PLACE = place_at(0.0, 0.0, 0.0, 0.0)


def spreading(factor: float, **others: object) -> Ink:
    """An ink whose bead is so much wider than a round filament."""
    return Ink(lambda plan: factor * round_width(plan.flow, plan.speed),
               **others)  # type: ignore[arg-type]


def of_print(judgement: Judgement) -> dict[str, float]:
    return {finding.quantity: finding.value for finding in judgement.findings
            if finding.of == 'print'}


def test_a_row_for_each_line() -> None:
    sweep = judge(SWEEP, printed(SWEEP, spreading(1.3)), PLACE).sweep
    assert sweep is not None
    assert [result.line for result in sweep.lines] == list(range(2, 10))
    for result in sweep.lines:
        width = 1.3 * round_width(result.plan.flow, result.plan.speed)
        begin, end = result.plan.judged
        assert result.width == pytest.approx(width)
        assert result.height == pytest.approx(0.5 * width)
        assert result.area == pytest.approx(width**2 / 3)
        assert result.samples == pytest.approx((end - begin) / (0.05 * MM), abs=2)
        # Half of the variance of a width is alike all over a print, and does not average out.
        assert SIGMA * np.sqrt(0.5) < result.width_sigma < SIGMA
        assert result.area_sigma >= 0.03 * result.area
        assert result.note == ''


def test_where_the_design_lies_is_found() -> None:
    there = pose((0.5, 0.1, 0.02), (30, 0, 0))
    profile = printed(SWEEP, spreading(1.3), there, spacing=0.2 * MM)
    sweep = judge(SWEEP, profile).sweep
    assert sweep is not None
    assert [round(1e6 * result.width) for result in sweep.lines] == [
        round(1.3e6 * round_width(result.plan.flow, result.plan.speed)) for result in sweep.lines]


def test_another_print_is_refused() -> None:
    profile = printed(wall(SETUP, 2), spreading(1.3), spacing=0.5 * MM)
    with pytest.raises(DesignError, match='registration'):
        judge(SWEEP, profile)


def test_the_start_of_a_line_does_not_count() -> None:
    ink = spreading(1.3)
    profile = printed(SWEEP, ink)
    sweep = judge(SWEEP, profile, PLACE).sweep
    assert sweep is not None
    fast = max(range(len(sweep.lines)), key=lambda index: sweep.lines[index].plan.speed)
    own = np.flatnonzero(profile.stroke == sweep.lines[fast].line)
    # 2 mm and a second of 6 mm/s.
    swollen = own[profile.arc_length[own] - profile.arc_length[own[0]] < 7.9 * MM]
    profile.thickness[swollen] *= 3
    again = judge(SWEEP, profile, PLACE).sweep
    assert again is not None
    assert again.lines[fast].width == sweep.lines[fast].width


@pytest.mark.parametrize(('share', 'width'), [(0.02, True), (0.3, False)])
def test_a_torn_line_has_no_width(share: float, width: bool) -> None:
    sweep = judge(SWEEP, printed(SWEEP, spreading(1.3, torn=share)), PLACE).sweep
    assert sweep is not None
    assert {np.isfinite(result.width) for result in sweep.lines} == {width}
    assert {'torn' in result.note for result in sweep.lines} == {not width}


def test_lines_that_are_not_printed_are_named() -> None:
    judgement = judge(SWEEP, printed(SWEEP, spreading(1.3), left_out=(3, 5)), PLACE)
    assert judgement.missing == [4, 6]
    assert judgement.sweep is not None
    assert {result.line: result.note for result in judgement.sweep.lines
            if np.isnan(result.width)} == dict.fromkeys((4, 6), 'it is not printed')


@pytest.mark.parametrize(('start', 'stop'), [(0.15, 0.1), (0.02, 0.35), (-0.1, -0.05)])
def test_lags_are_found_again(start: float, stop: float) -> None:
    profile = printed(SWEEP, spreading(1.3, start_lag=start, stop_lag=stop))
    sweep = judge(SWEEP, profile, PLACE, period=PERIOD).sweep
    assert sweep is not None
    for lag, true in ((sweep.start, start), (sweep.stop, stop)):
        assert lag.time == pytest.approx(true, abs=3 * lag.sigma)
        assert lag.sigma < 0.02
        assert lag.lines == len(sweep.lines)
    for result in sweep.lines:
        assert result.start.time == pytest.approx(start, abs=0.05 * MM / result.plan.speed)
        assert result.stop.time == pytest.approx(stop, abs=0.05 * MM / result.plan.speed)


def test_how_far_ink_seems_to_reach_is_told_from_the_lag() -> None:
    """A camera that sees every edge 0.2 mm too far out does not shift the lag."""
    away = 0.2 * MM
    profile = printed(SWEEP, spreading(1.3, start_lag=0.15, stop_lag=0.1))
    status = profile.status.copy()
    arc = profile.arc_length
    inked = np.isin(status, (Status.MEASURED, Status.OOZE))
    for index in np.flatnonzero(inked[1:] != inked[:-1]):
        edge = (arc[index] + arc[index + 1]) / 2
        near = np.abs(arc - edge) < away
        status[near & (profile.stroke > 0)] = Status.MEASURED
        status[near & (profile.stroke == 0)] = Status.OOZE
    sweep = judge(SWEEP, replace(profile, status=status), PLACE, period=PERIOD).sweep
    assert sweep is not None
    assert sweep.start.time == pytest.approx(0.15, abs=3 * sweep.start.sigma)
    assert sweep.stop.time == pytest.approx(0.1, abs=3 * sweep.stop.sigma)
    assert sweep.start.away == pytest.approx(-away, abs=0.05 * MM)
    assert sweep.stop.away == pytest.approx(away, abs=0.05 * MM)


def test_lines_of_one_speed_do_not_tell_how_far_ink_seems_to_reach() -> None:
    test = lines(SETUP, [0.2e-9, 0.3e-9, 0.4e-9], [4 * MM])
    sweep = judge(test, printed(test, spreading(1.3, start_lag=0.15)), PLACE).sweep
    assert sweep is not None
    assert np.isnan(sweep.start.away)
    assert 'of one speed' in sweep.start.note
    width = 1.3 * round_width(0.3e-9, 4 * MM)
    assert sweep.start.sigma > 0.9 * width / 4 / (4 * MM)


def test_a_lag_that_is_not_seen_has_a_reason() -> None:
    profile = printed(SWEEP, spreading(1.3, stop_lag=9.0))
    sweep = judge(SWEEP, profile, PLACE).sweep
    assert sweep is not None
    assert np.isnan(sweep.stop.time)
    assert sweep.stop.note == 'ink is seen to the end of the way behind it'
    hidden = replace(profile, extruder_known=np.zeros(len(profile), bool))
    sweep = judge(SWEEP, hidden, PLACE).sweep
    assert sweep is not None
    assert sweep.start.note == 'when the extruder was told is not recorded'
    travel = profile.stroke == 0
    unseen = replace(profile, status=np.where(
        travel | (profile.status == Status.GAP), Status.NO_DATA, profile.status).astype(np.uint8))
    sweep = judge(SWEEP, unseen, PLACE).sweep
    assert sweep is not None
    assert np.isnan(sweep.start.time)
    assert sweep.start.lines == 0


def test_ink_behind_a_stroke_is_its_own_where_travel_does_not_tell() -> None:
    profile = printed(SWEEP, spreading(1.3, stop_lag=0.1))
    ooze = profile.status == Status.OOZE
    assert ooze.any()
    doubted = replace(profile, status=np.where(ooze, Status.NO_DATA, profile.status).astype(
        np.uint8), cause=np.where(ooze, Cause.OVER_STROKE, Cause.NONE).astype(np.uint8))
    sweep = judge(SWEEP, doubted, PLACE, period=PERIOD).sweep
    assert sweep is not None
    assert sweep.stop.time == pytest.approx(0.1, abs=3 * sweep.stop.sigma)


def test_drift_is_told_by_the_line_that_is_repeated() -> None:
    ink = spreading(1.0)
    profile = printed(SWEEP, ink)
    last = profile.stroke == len(SWEEP.plans)
    later = replace(profile, thickness=np.where(last, 1.1 * profile.thickness, profile.thickness))
    found = of_print(judge(SWEEP, later, PLACE))
    assert found['drift_of_width'] == pytest.approx(10, abs=1e-6)
    assert of_print(judge(SWEEP, profile, PLACE))['drift_of_width'] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize('width', [0.7, 0.9, 1.1])
def test_strands_fuse_as_far_apart_as_they_are_wide(width: float) -> None:
    test = fusion(SETUP, [0.4 * MM, 0.6 * MM, 0.8 * MM, 1.0 * MM, 1.2 * MM, 1.4 * MM])
    found = judge(test, printed(test, Ink(width * MM)), PLACE).findings[0]
    assert found.quantity == 'fusing_distance'
    assert found.value == pytest.approx(width * MM, abs=0.1 * MM + 1e-9)
    assert found.sigma == pytest.approx(0.2 * MM / np.sqrt(12))


@pytest.mark.parametrize(('width', 'note'), [(0.1, 'all are apart'), (3.0, 'all are fused')])
def test_distances_that_do_not_enclose_it(width: float, note: str) -> None:
    test = fusion(SETUP, [0.8 * MM, 1.0 * MM])
    found = judge(test, printed(test, Ink(width * MM)), PLACE).findings[0]
    assert np.isnan(found.value)
    assert note in found.note


def test_a_turn_that_swells() -> None:
    test = turns(SETUP)
    profile = printed(test, Ink(0.5 * MM))
    index = test.numbers(Part.TURN)[1]
    own = np.flatnonzero(profile.stroke == index + 1)
    arc = profile.arc_length[own] - profile.arc_length[own[0]]
    apex = np.abs(arc - test.design.strokes[index].length / 2) < 1 * MM
    for values in (profile.left, profile.right, profile.thickness):
        values[own[apex]] *= 1.8
    judgement = judge(test, profile, PLACE)
    found = {finding.of: finding.value for finding in judgement.findings
             if finding.quantity == 'relative_width_at_apex'}
    assert found.pop('turn of 90 deg, radius 0.00 mm') == pytest.approx(1.8)
    assert list(found.values()) == [pytest.approx(1.0)] * 6
    assert of_print(judgement)['turn_fidelity'] == pytest.approx(6 / 7)


def test_a_turn_whose_apex_is_not_measured_has_no_width() -> None:
    test = turns(SETUP)
    profile = printed(test, Ink(0.5 * MM))
    own = profile.stroke == test.numbers(Part.TURN)[0] + 1
    status = np.where(own, Status.JUNCTION, profile.status).astype(np.uint8)
    judgement = judge(test, replace(profile, status=status), PLACE)
    first = next(finding for finding in judgement.findings if finding.of != 'print')
    assert np.isnan(first.value)
    assert judgement.findings[0].note == '1 more turns are not measured'


def test_the_pores_of_a_lattice() -> None:
    test = lattice(SETUP, 3, 2 * MM)
    found = of_print(judge(test, printed(test, Ink(0.8 * MM), spacing=0.1 * MM),
                           PLACE))
    assert found['pore_area'] == pytest.approx(1.2**2 * MM**2, rel=0.01)
    assert found['pore_printability'] == pytest.approx(1, abs=0.01)
    assert found['mesh_printability'] == pytest.approx(100 * 1.2**2 / (2 - 0.41)**2, rel=0.01)
    assert found['filament_to_nozzle_ratio'] == pytest.approx(0.8 / 0.41)


def test_how_far_a_line_sags() -> None:
    test = line_over_lines(SETUP, [4 * MM, 6 * MM])
    profile = printed(test, Ink(0.6 * MM))
    (span,) = (test.design.strokes[index] for index in test.numbers(Part.SPAN))
    supports = [float(test.design.strokes[index].points[0, 0])
                for index in test.numbers(Part.SUPPORT)]
    x = np.linspace(span.points[0, 0], span.points[1, 0], 4000)
    sag, high = np.zeros(len(x)), 0.3 * MM  # supports are half as high as wide
    for begin, end, depth in zip(supports, supports[1:], (0.03, 0.12), strict=False):
        # Between the edges of the supports.
        share = (x - begin - 0.3 * MM) / (end - begin - 0.6 * MM)
        sag += np.where((share > 0) & (share < 1), 4 * depth * MM * share * (1 - share), 0.0)
    top = profile.points[:, 2].max() + 0 * x  # of the line, somewhere above the bed
    cloud = np.column_stack((x, np.full(len(x), span.points[0, 1]), top - sag))
    judgement = judge(test, profile, PLACE, cloud)
    found = {finding.of: finding for finding in judgement.findings
             if finding.quantity == 'collapse_factor'}
    for name, depth in (('span 1', 0.03), ('span 2', 0.12)):
        # Of a parabola two thirds of the depth.
        assert found[name].value == pytest.approx(100 * 2 / 3 * depth * MM / high, rel=0.05)
    assert found['span 2'].at == 6 * MM


def test_without_a_cloud_sag_is_not_told() -> None:
    test = line_over_lines(SETUP)
    judgement = judge(test, printed(test, Ink(0.6 * MM)), PLACE)
    assert np.isnan(judgement.findings[0].value)
    assert 'name the recording' in judgement.findings[0].note
    widths = {finding.of: finding.value for finding in judgement.findings
              if finding.quantity == 'width'}
    assert widths == {'lines below': pytest.approx(0.6 * MM),
                      'line across': pytest.approx(0.6 * MM)}


def test_the_layers_of_a_wall() -> None:
    test = wall(SETUP, 4)
    judgement = judge(test, printed(test, Ink(0.8 * MM, height=0.4)), PLACE)
    layers = [finding for finding in judgement.findings if finding.quantity == 'layer_height']
    assert [finding.of for finding in layers] == [f'layer {number}' for number in (1, 2, 3, 4)]
    assert [finding.value for finding in layers] == [pytest.approx(0.32 * MM)] * 4
    assert {finding.at for finding in layers} == {SETUP.height}
    height = judgement.findings[0]
    assert height.value == pytest.approx(4 * 0.32 * MM)
    # What is wrong alike in all layers adds up.
    assert 4 * layers[0].sigma * np.sqrt(0.5) < height.sigma < 4 * layers[0].sigma


def test_a_wall_of_which_a_layer_is_not_seen() -> None:
    test = wall(SETUP, 4)
    profile = printed(test, Ink(0.8 * MM))
    hidden = replace(profile, height=np.where(profile.stroke == 3, np.nan, profile.height))
    height = judge(test, hidden, PLACE).findings[0]
    assert np.isnan(height.value)
    assert height.note == 'of 1 of 4 layers the height is not known'
