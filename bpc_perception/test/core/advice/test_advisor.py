"""Advice: the right factor on what is in force, or the right reason for none.

Truth by the mass balance: a bead of width w laid at speed v from a flow Q of which the share g
arrives has w^2 = c g Q / v. The constant is that for which the print is set up right.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from perception_builders import path_through, profile_of, SECOND, START_NS
import pytest

from bpc_perception.core.advice.advisor import Advisor
from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.arrays import Array
from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets

TARGET, FLOW, SPEED = 2e-3, 1e-8, 0.01
SPACING = 2e-4
CONFIG = AdviceConfig(target_thickness=TARGET, slew_rate=100, acquisition_time=0)
M, GAP, NO_DATA, BARE = Status.MEASURED, Status.GAP, Status.NO_DATA, Status.BARE


def width(flow: Any = FLOW, speed: float = SPEED, share: Any = 1.0) -> Any:
    """The bead [m] that this makes, where FLOW at SPEED makes what is wanted."""
    return TARGET * np.sqrt(share * flow / FLOW * SPEED / speed)


def laid(count: int, flow: Any = FLOW, speed: float = SPEED, **changes: Any) -> DepositionPath:
    """A path of points SPACING apart on which this flow was commanded."""
    points = np.column_stack((SPACING * np.arange(count), np.zeros((count, 2))))
    path = path_through(points, speed=speed)
    return replace(path, flow_rate=np.broadcast_to(np.asarray(flow, float), count).copy(),
                   **changes)


def seen(path: DepositionPath, thickness: Any, status: Any = None, delay: float = 0.1,
         offset: float = 0.0) -> ThicknessProfile:
    """What is measured of it."""
    values = np.broadcast_to(np.asarray(thickness, float), len(path)).copy()
    profile = profile_of(values.tolist(), status, spacing=SPACING)
    # An extruder that never pushes is not heard; what is commanded is one stroke up to travel.
    travel = path.extruder_known & path.extruding.any() & ~path.extruding
    stroke = np.where(travel, 0, 1 + np.cumsum(np.diff(travel, prepend=False) & travel))
    return replace(profile, stamp_ns=START_NS + round((path.time[-1] + delay) * SECOND),
                   print_id=path.print_id, time=path.time, extruding=path.extruding,
                   extruder_known=path.extruder_known, stroke=stroke,
                   left=values / 2 + offset, right=values / 2 - offset)


def advise(path: DepositionPath, thickness: Any, status: Any = None, config: AdviceConfig = CONFIG,
           advisor: Advisor | None = None, **seeing: Any) -> RateAdvice:
    return (advisor or Advisor()).advise(seen(path, thickness, status, **seeing), path, config)


def assert_changes_nothing(result: RateAdvice, reason: Reason) -> None:
    assert result.reason is reason
    assert not result.valid
    assert (result.flow_rate_scale, result.speed_scale, result.confidence) == (1, 1, 0)


def nearly(factor: float) -> Any:
    """A factor up to 2 % nearer to 1: more ink only as far as it is missing for sure."""
    return pytest.approx((0.99 if factor > 1 else 1.01) * factor, rel=0.01)


@pytest.mark.parametrize(('share', 'reason'), [
    (0.7, Reason.UNDER_EXTRUSION), (0.85, Reason.UNDER_EXTRUSION),
    (1.2, Reason.OVER_EXTRUSION), (1.5, Reason.OVER_EXTRUSION)])
def test_what_does_not_arrive_is_made_up_for(share: float, reason: Reason) -> None:
    result = advise(laid(300), width(share=share))
    assert (result.valid, result.reason) == (True, reason)
    assert result.flow_rate_scale == nearly(1 / share)
    assert result.speed_scale == nearly(share)
    assert result.delivery == pytest.approx(share, rel=0.01)
    assert result.expected_thickness == pytest.approx(width(share=share), rel=0.005)
    assert result.measured_thickness == pytest.approx(width(share=share))
    assert result.target_thickness == TARGET
    assert 0.95 < result.confidence <= 1
    assert result.flow_rate == pytest.approx(FLOW * result.flow_rate_scale)
    assert result.speed == pytest.approx(SPEED * result.speed_scale)


def test_on_target_nothing_changes() -> None:
    result = advise(laid(300), width())
    assert (result.valid, result.reason) == (True, Reason.ON_TARGET)
    assert (result.flow_rate_scale, result.speed_scale) == (1, 1)


@pytest.mark.parametrize('changed', [10, 30, 45])
def test_what_was_corrected_and_is_not_seen_yet_is_not_corrected_again(changed: int) -> None:
    """30 % do not arrive; the controller made up for it, some points before the capture."""
    flow = np.full(300, FLOW)
    flow[-changed:] /= 0.7
    status = [M] * (300 - changed) + [NO_DATA] * changed
    result = advise(laid(300, flow), width(share=0.7), status)
    assert (result.valid, result.reason) == (True, Reason.ON_TARGET)
    assert result.measured_thickness == pytest.approx(width(share=0.7))
    assert result.expected_thickness == pytest.approx(TARGET, rel=0.005)


def test_a_change_of_speed_counts_as_one_of_flow() -> None:
    """Laid at half the speed, twice as much lies there: nothing is wrong with the delivery."""
    path = laid(300)
    slow = np.arange(300) >= 150
    time = np.concatenate(([0], np.cumsum(np.where(slow, 2, 1)[1:] * SPACING / SPEED)))
    path = replace(path, time=time, complete_until=float(time[-1]))
    result = advise(path, np.where(slow, width(speed=SPEED / 2), width()))
    assert result.delivery == pytest.approx(1, abs=0.02)
    assert result.flow_rate_scale == pytest.approx(0.5, rel=0.03)


@pytest.mark.parametrize('behind', [1, 5, 15, 40])
def test_a_hole_in_the_path_that_cuts_a_corner_teaches_nothing(behind: int) -> None:
    """Poses of 4 mm are missing, the straight way over which is half as long."""
    path = laid(300)
    after = np.arange(300) >= 300 - behind
    time, arc = path.time + after * 4e-3 / SPEED, path.arc_length + after * 2e-3
    path = replace(path, time=time, arc_length=arc, complete_until=float(time[-1]),
                   points=np.column_stack((arc, np.zeros((300, 2)))))
    result = advise(path, width())
    assert (result.valid, result.reason) == (True, Reason.ON_TARGET)
    assert result.delivery == pytest.approx(1, abs=0.005)


def lagged(path: DepositionPath, lag: float) -> Array:
    """Flow behind a first-order lag, by its equation, with the path's steps of time."""
    flow = np.zeros(len(path))
    for index in range(1, len(flow)):
        keep = np.exp(-(path.time[index] - path.time[index - 1]) / lag)
        flow[index] = keep * flow[index - 1] + (1 - keep) * path.flow_rate[index - 1]
    return flow


@pytest.mark.parametrize('lag', [1.0, 4.0])
def test_a_slow_start_is_known_for_a_lag(lag: float) -> None:
    path = laid(800)
    arriving = width(lagged(path, lag))
    status = [M if value > 3e-4 else GAP for value in arriving]
    result = advise(path, np.where(arriving > 3e-4, arriving, 0), status)
    assert result.lag == pytest.approx(lag, rel=0.35)
    assert result.delivery == pytest.approx(1, abs=0.12)


def test_unevenness_makes_less_certain_and_less_bold() -> None:
    rng = np.random.default_rng(1)
    path = laid(100)
    even = advise(path, width(share=0.8))
    uneven = advise(path, width(share=0.8) * np.repeat(1 + 0.2 * rng.standard_normal(20), 5))
    assert uneven.delivery_sigma > 3 * even.delivery_sigma
    assert uneven.confidence < even.confidence


def test_uncertain_samples_weigh_less() -> None:
    path = laid(200)
    profile = seen(path, width(share=0.8))
    rough = replace(profile, sigma=np.full(200, 4e-4))
    assert Advisor().advise(rough, path, CONFIG).delivery_sigma > Advisor().advise(
        profile, path, CONFIG).delivery_sigma


def test_a_step_is_limited_by_time() -> None:
    path = laid(300)
    result = advise(path, width(share=0.7), config=replace(CONFIG, slew_rate=0.01))
    elapsed = path.time[-1] + 0.1
    assert (result.valid, result.reason) == (True, Reason.LIMITED)
    assert result.flow_rate_scale == pytest.approx(np.exp(0.01 * elapsed))
    assert result.speed_scale == pytest.approx(np.exp(-0.01 * elapsed))


@pytest.mark.parametrize(('count', 'elapsed'), [
    (600, 12.08), (1000, CONFIG.lifetime), (3000, CONFIG.lifetime)])
def test_who_begins_amid_a_print_takes_no_longer_step_than_advice_lives(
        count: int, elapsed: float) -> None:
    """As after a restart; 12 s into the print it may have been the first to look."""
    result = advise(laid(count), width(share=0.7), config=replace(CONFIG, slew_rate=0.01))
    assert (result.valid, result.reason) == (True, Reason.LIMITED)
    assert result.flow_rate_scale == pytest.approx(np.exp(0.01 * elapsed))
    assert result.speed_scale == pytest.approx(np.exp(-0.01 * elapsed))


@pytest.mark.parametrize(('share', 'flow', 'speed'), [(0.3, 2, 0.5), (3.0, 0.5, 2)])
def test_more_than_allowed_is_limited(share: float, flow: float, speed: float) -> None:
    result = advise(laid(300), width(share=share))
    assert (result.valid, result.reason) == (True, Reason.LIMITED)
    assert result.flow_rate_scale == pytest.approx(flow, rel=0.01)
    assert result.speed_scale == pytest.approx(speed, rel=0.01)


@pytest.mark.parametrize('limits', [(0.1, 1.2), (0.9, 10.0)])
@pytest.mark.parametrize('share', [0.6, 1.6])
def test_no_factor_passes_its_limits_unsaid(limits: tuple[float, float], share: float) -> None:
    low, high = limits
    result = advise(laid(300), width(share=share),
                    config=replace(CONFIG, minimum_scale=low, maximum_scale=high))
    assert low <= result.flow_rate_scale <= high
    assert low <= result.speed_scale <= high
    assert result.reason is Reason.LIMITED


def test_following_does_not_pass_the_limits_in_steps() -> None:
    """However often it is followed: what is commanded stays within what the print began with."""
    advisor, flow = Advisor(), np.full(100, FLOW)
    for _ in range(12):
        path = laid(len(flow), flow, print_id='one')
        result = advise(path, width(flow, share=0.2), advisor=advisor)
        assert result.valid
        flow = np.concatenate((flow, np.full(100, flow[-1] * result.flow_rate_scale)))
    assert flow[-1] == pytest.approx(2 * FLOW, rel=0.05)
    assert flow.max() <= 2.05 * FLOW


def test_without_a_target_there_is_no_advice() -> None:
    result = advise(laid(300), width(), config=AdviceConfig())
    assert_changes_nothing(result, Reason.NO_TARGET)
    assert np.isnan(result.target_thickness)


def test_targets_along_the_path_are_looked_up_where_the_advice_takes_effect() -> None:
    path = laid(301)  # 60 mm, of which the last third is to be 20 % wider
    step = float(path.arc_length[-1]) + 1e-3
    targets = WidthTargets(np.array((0, step, step)), np.array((TARGET, TARGET, 1.2 * TARGET)))
    result = advise(path, width(), advisor=Advisor(targets))
    assert result.target_thickness == pytest.approx(1.2 * TARGET)
    assert result.flow_rate_scale == nearly(1.44)


@pytest.mark.parametrize(('gap', 'alarm'), [(5, False), (15, True), (40, True)])
def test_ink_missing_over_some_length_is_an_alarm(gap: int, alarm: bool) -> None:
    status = [M] * 240 + [GAP] * gap + [M] * (60 - gap)
    result = advise(laid(300), [width(share=0.8) if s == M else 0 for s in status], status)
    if alarm:
        assert_changes_nothing(result, Reason.GAP_DETECTED)
    else:
        assert result.reason is Reason.UNDER_EXTRUSION
        assert result.flow_rate_scale == pytest.approx(1.25, rel=0.02)


def test_what_was_laid_while_the_camera_looked_is_no_gap() -> None:
    status = [M] * 280 + [GAP] * 20  # the newest 0.4 s
    looking = replace(CONFIG, acquisition_time=0.6)
    result = advise(laid(300), [width() if s == M else 0 for s in status], status, looking)
    assert (result.valid, result.reason) == (True, Reason.ON_TARGET)


def test_a_gap_made_on_purpose_is_no_alarm() -> None:
    path = laid(300)
    on = np.abs(np.arange(300) - 270) > 15
    path = replace(path, extruding=on, flow_rate=np.where(on, FLOW, 0.0))
    result = advise(path, np.where(on, width(), np.nan), np.where(on, M, BARE))
    assert result.valid
    assert result.reason is not Reason.LIMITED


def print_of(number: int, flow: float, share: float, advisor: Advisor) -> RateAdvice:
    """Advice on a print with a flow of its own, of which a share arrives."""
    return advise(laid(300, flow, print_id=f'print {number}'), width(flow, share=share),
                  advisor=advisor)


@pytest.mark.parametrize(('share', 'most'), [(0.1, 2.0), (5.0, 0.5)])
def test_limits_hold_over_the_prints_of_a_run(share: float, most: float) -> None:
    advisor, flow = Advisor(), FLOW
    for number in range(4):
        result = print_of(number, flow, share, advisor)
        assert (result.valid, result.reason) == (True, Reason.LIMITED)
        flow *= result.flow_rate_scale
    assert flow == pytest.approx(most * FLOW, rel=0.02)
    # Another advisor, as after a restart, goes on with the setup of the first.
    again = print_of(9, flow, share, Advisor(setup=advisor.setup))
    assert again.flow_rate_scale == pytest.approx(1.0, abs=0.03)


def test_a_print_that_no_advice_leads_to_has_a_setup_of_its_own() -> None:
    advisor = Advisor()
    print_of(1, FLOW, 1.0, advisor)
    result = print_of(2, 4 * FLOW, 0.25 / 1.5, advisor)  # with another nozzle, say
    assert result.flow_rate_scale == pytest.approx(1.5, rel=0.02)


def test_advice_counts_as_followed_where_the_rate_is_not_recorded() -> None:
    advisor, total = Advisor(), 1.0
    for number in range(4):
        path = laid(300, np.nan, plunger_velocity=np.full(300, np.nan), print_id=str(number))
        result = advise(path, width(share=0.1), advisor=advisor)
        total *= result.flow_rate_scale
    assert total == pytest.approx(2.0, rel=0.02)


def test_a_sudden_fall_is_a_clog_and_no_bigger_rate() -> None:
    advisor, path = Advisor(), laid(400)
    assert advise(path.until(START_NS + 6 * SECOND), width(), advisor=advisor).valid
    share = np.where(np.arange(400) < 370, 1, 0.35)
    result = advise(path, width(share=share), advisor=advisor)
    assert_changes_nothing(result, Reason.CLOG_SUSPECTED)
    assert result.delivery == pytest.approx(1, abs=0.02)


def test_a_bead_beside_the_path_is_an_alarm() -> None:
    assert_changes_nothing(advise(laid(300), width(), offset=1.1e-3), Reason.PATH_OFFSET)
    assert advise(laid(300), width(), offset=-0.9e-3).valid


@pytest.mark.parametrize('fault', ['silent', 'stands'])
def test_an_extruder_that_stopped_is_an_alarm(fault: str) -> None:
    path = laid(300)
    flow, on, known = (array.copy() for array in (
        path.flow_rate, path.extruding, path.extruder_known))
    if fault == 'silent':
        flow[-10:], on[-10:], known[-10:] = np.nan, False, False
    else:
        flow[-10:] = 0
    path = replace(path, flow_rate=flow, extruding=on, extruder_known=known)
    assert_changes_nothing(advise(path, width()), Reason.EXTRUDER_FAULT)


def test_an_extruder_that_was_silent_for_a_while_does_not_raise_the_rate() -> None:
    path = laid(300)
    silent = (np.arange(300) >= 200) & (np.arange(300) < 275)  # for 1.5 s
    path = replace(path, flow_rate=np.where(silent, np.nan, FLOW), extruding=~silent,
                   extruder_known=~silent)
    result = advise(path, width(), config=replace(CONFIG, minimum_coverage=0.1))
    assert (result.valid, result.reason) == (True, Reason.ON_TARGET)


def test_a_path_that_ends_before_the_capture_is_stale_and_does_not_prolong_the_last() -> None:
    advisor, path = Advisor(), replace(laid(300), finished=False)
    first = advise(path, width(share=0.8), advisor=advisor, delay=0.0)
    assert first.valid
    late = advise(path, width(share=0.8), advisor=advisor, delay=2.0)
    assert_changes_nothing(late, Reason.STALE_DATA)
    assert late.valid_until_ns == first.valid_until_ns


@pytest.mark.parametrize(('delay', 'stale'), [(19.9, False), (20.1, True)])
def test_old_measurements_are_stale(delay: float, stale: bool) -> None:
    result = advise(laid(300), width(share=0.8), delay=delay)
    assert result.measurement_age == pytest.approx(delay)
    assert result.valid == (not stale)
    if stale:
        assert_changes_nothing(result, Reason.STALE_DATA)


@pytest.mark.parametrize(('measured', 'enough'), [(9, False), (10, True)])
def test_few_samples_are_not_enough(measured: int, enough: bool) -> None:
    status = [M] * measured + [NO_DATA] * (18 - measured)
    result = advise(laid(18), width(share=0.8), status)
    assert result.sample_count == measured
    assert result.valid == enough
    if not enough:
        assert_changes_nothing(result, Reason.NOT_ENOUGH_DATA)


def test_little_coverage_is_not_enough_and_never_raises_the_rate() -> None:
    status = [M] * 240 + [NO_DATA] * 60  # 8 of the newest 20 mm
    assert_changes_nothing(advise(laid(300), width(share=0.8), status), Reason.NOT_ENOUGH_DATA)


def test_nothing_measured_and_nothing_commanded() -> None:
    assert_changes_nothing(advise(laid(300), np.nan, [NO_DATA] * 300), Reason.NOT_ENOUGH_DATA)
    off = laid(300, 0.0, extruding=np.zeros(300, bool))
    result = advise(off, 0.0, [GAP] * 300)
    assert_changes_nothing(result, Reason.NOT_ENOUGH_DATA)
    assert np.isnan(result.window).all()


def test_the_plunger_stands_for_an_unknown_flow() -> None:
    path = replace(laid(300, np.nan), plunger_velocity=np.where(np.arange(300) < 280, 1e-4, 2e-4))
    status = [M] * 280 + [NO_DATA] * 20
    result = advise(path, width(share=0.5), status)
    assert result.reason is Reason.ON_TARGET  # it has been doubled already
    assert np.isnan(result.flow_rate)
    assert result.plunger_velocity == pytest.approx(2e-4)


def test_a_rate_that_nobody_records_is_corrected_once_and_then_waited_for() -> None:
    path = laid(400, np.nan, plunger_velocity=np.full(400, np.nan), print_id='one')
    advisor = Advisor()
    before = path.where(np.arange(400) < 300)
    assert advise(before, width(share=0.8), advisor=advisor).flow_rate_scale == pytest.approx(
        1.25, rel=0.02)
    # Not seen yet: what lies there was laid before.
    soon = path.where(np.arange(400) < 320)
    assert_changes_nothing(advise(soon, width(share=0.8), advisor=advisor),
                           Reason.NOT_ENOUGH_DATA)
    followed = np.where(np.arange(400) < 320, width(share=0.8), width())
    assert advise(path, followed, advisor=advisor).reason is Reason.ON_TARGET


def test_where_nobody_records_the_rate_who_begins_amid_a_print_waits_for_new_ink() -> None:
    """Another may have advised a correction that is in force, but not seen yet."""
    path = laid(1200, np.nan, plunger_velocity=np.full(1200, np.nan), print_id='one')
    advisor, followed = Advisor(), np.where(np.arange(1200) < 1000, width(share=0.8), width())
    for count in (1000, 1020):
        part = path.where(np.arange(1200) < count)
        assert_changes_nothing(advise(part, followed[:count], advisor=advisor),
                               Reason.NOT_ENOUGH_DATA)
    assert advise(path, followed, advisor=advisor).reason is Reason.ON_TARGET


def test_advice_holds_until_two_captures_are_missed_or_its_lifetime_is_over() -> None:
    advisor, path = Advisor(), laid(600, print_id='one')
    lives = []
    for count in (300, 400, 500):  # 2 s apart
        part = path.where(np.arange(600) < count)
        result = advise(part, width(), advisor=advisor, config=replace(CONFIG, lifetime=7.5))
        lives.append((result.valid_until_ns - result.stamp_ns) / SECOND)
    assert lives == pytest.approx([7.5, 4.5, 4.5])


def test_the_same_captures_give_the_same_advice_to_the_last_bit() -> None:
    rng = np.random.default_rng(3)
    thickness = width(share=0.85) * (1 + 0.1 * rng.standard_normal(600))
    path = laid(600, print_id='one')

    def all_advice(further: int) -> list[RateAdvice]:
        """With a path that is known so many points beyond each capture, as live it may be."""
        advisor, found = Advisor(), []
        for count in (100, 250, 400, 550):
            part = path.where(np.arange(600) < count)
            known = path.where(np.arange(600) < count + further)
            profile = seen(part, thickness[:count], delay=1e-6)
            found.append(advisor.advise(profile, known, CONFIG))
        return found

    assert [repr(advice) for advice in all_advice(0)] == [repr(a) for a in all_advice(50)]


def test_a_new_print_and_a_clock_that_went_back_begin_anew() -> None:
    fresh = advise(laid(300), width(share=0.9))
    for print_id in ('print', 'other'):
        advisor = Advisor()
        advise(laid(500, print_id=print_id), width(share=0.6), advisor=advisor)
        assert repr(advise(laid(300), width(share=0.9), advisor=advisor)) == repr(fresh)


def test_a_nozzle_that_darts_says_nothing_of_the_speed_in_force() -> None:
    """Poses that come again, or a clock that is set: a few steps in no time at the end."""
    path = laid(200)
    time = path.time.copy()
    time[-10:] = time[-11] + 0.001 * np.arange(1, 11)
    assert advise(replace(path, time=time), TARGET).flow_rate_scale == pytest.approx(1, abs=0.02)


def test_a_slow_corner_just_now_says_nothing_of_what_is_to_come() -> None:
    path = laid(200)
    step = np.diff(path.time, prepend=0.0)
    step[-8:] *= 2  # half as fast: twice the ink
    time = np.cumsum(step)
    thickness = np.full(200, TARGET)
    thickness[-8:] *= np.sqrt(2)
    assert advise(replace(path, time=time), thickness).flow_rate_scale == pytest.approx(
        1, abs=0.03)


def test_nothing_is_advised_where_the_way_is_lost_for_long() -> None:
    """Holes between path points for two seconds: at which speed was ink laid?"""
    path = laid(400)
    kept = np.ones(400, bool)
    kept[200:] = np.arange(200) % 20 < 5
    lost = path.where(kept)
    assert advise(path, TARGET).valid
    advice = advise(lost, np.full(len(lost), TARGET))
    assert not advice.valid
    assert advice.reason == Reason.STALE_DATA


def test_ink_that_seems_to_become_narrower_is_not_made_up_for() -> None:
    advisor = Advisor()
    path = laid(200)
    assert advise(path.where(np.arange(200) < 150), TARGET, advisor=advisor).valid
    advice = advise(path, 0.7 * TARGET, advisor=advisor)
    assert not advice.valid
    assert advice.reason == Reason.NOT_ENOUGH_DATA
    assert advice.flow_rate_scale == 1


NOMINAL = FLOW / SPEED  # area that was commanded


def with_area(path: DepositionPath, thickness: float, area: float) -> ThicknessProfile:
    """What is measured of a bead of this width and area."""
    profile = seen(path, thickness)
    return replace(profile, area=np.full(len(path), area),
                   area_sigma=np.full(len(path), 0.02 * area))


def test_a_squashed_bead_is_not_too_much_ink() -> None:
    """Wide and low: a fifth wider, but as much ink as was commanded."""
    path = laid(200)
    by_width = Advisor().advise(seen(path, 1.2 * TARGET), path, CONFIG)
    assert by_width.reason == Reason.OVER_EXTRUSION
    assert not by_width.by_volume
    advice = Advisor().advise(with_area(path, 1.2 * TARGET, NOMINAL), path, CONFIG)
    assert advice.valid
    assert advice.by_volume
    assert advice.reason == Reason.VOLUME_DISAGREES
    assert advice.flow_rate_scale == 1
    assert advice.measured_area == pytest.approx(NOMINAL)


@pytest.mark.parametrize('share', [0.8, 1.25])
def test_what_width_and_volume_agree_on_is_corrected(share: float) -> None:
    path = laid(200)
    advice = Advisor().advise(with_area(path, width(share=share), share * NOMINAL), path, CONFIG)
    assert advice.by_volume
    assert advice.flow_rate_scale == pytest.approx(1 / share, rel=0.03)


def test_the_smaller_change_is_asked_for() -> None:
    path = laid(200)
    advice = Advisor().advise(with_area(path, width(share=0.6), 0.9 * NOMINAL), path, CONFIG)
    assert advice.flow_rate_scale == pytest.approx(1 / 0.9, rel=0.03)


def test_where_the_flow_is_not_the_volume_that_is_seen_the_width_counts() -> None:
    """An extruder whose flow is told in other units, or never calibrated."""
    path = laid(200)
    advice = Advisor().advise(with_area(path, width(share=0.8), 0.25 * NOMINAL), path, CONFIG)
    assert not advice.by_volume
    assert advice.flow_rate_scale == pytest.approx(1 / 0.8, rel=0.03)


def test_by_volume_can_be_switched_off() -> None:
    path = laid(200)
    config = replace(CONFIG, by_volume=False)
    advice = Advisor().advise(with_area(path, 1.2 * TARGET, NOMINAL), path, config)
    assert advice.reason == Reason.OVER_EXTRUSION
    assert not advice.by_volume
