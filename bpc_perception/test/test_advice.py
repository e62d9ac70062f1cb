"""Advice: the right factor, or the right reason for none."""

from __future__ import annotations

from typing import Any

from bpc_perception.core.advice import advise, RateAdvice, Reason
from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.profile import Status
import numpy as np
from perception_builders import profile_of, SECOND
import pytest

M, GAP, NO_DATA = Status.MEASURED, Status.GAP, Status.NO_DATA
TARGET = 2e-3


def advice(thickness: Any, status: Any = None, extruding: Any = None, delay: float = 1.0,
           **settings: Any) -> RateAdvice:
    profile = profile_of(thickness, status, extruding=extruding, delay=delay)
    return advise(profile, AdviceConfig(**{'target_thickness': TARGET, **settings}))


def assert_changes_nothing(result: RateAdvice, reason: Reason) -> None:
    assert result.reason is reason
    assert not result.valid
    assert (result.flow_rate_scale, result.speed_scale, result.confidence) == (1, 1, 0)


@pytest.mark.parametrize(('measured', 'reason', 'flow', 'speed'), [
    (1.6e-3, Reason.UNDER_EXTRUSION, 1.5625, 0.64),
    (2.5e-3, Reason.OVER_EXTRUSION, 0.64, 1.5625)])
def test_flow_goes_with_the_square_of_the_width_and_speed_against_it(
        measured: float, reason: Reason, flow: float, speed: float) -> None:
    result = advice([measured] * 30)
    assert (result.valid, result.reason) == (True, reason)
    assert result.flow_rate_scale == pytest.approx(flow)
    assert result.speed_scale == pytest.approx(speed)
    assert result.measured_thickness == pytest.approx(measured)
    assert result.target_thickness == TARGET
    assert result.confidence == pytest.approx(1)


@pytest.mark.parametrize(('measured', 'flow', 'speed'), [(1e-3, 2, 0.5), (4e-3, 0.5, 2),
                                                         (1.2e-3, 2, 0.5)])
def test_more_than_allowed_is_limited(measured: float, flow: float, speed: float) -> None:
    result = advice([measured] * 30)
    assert (result.valid, result.reason) == (True, Reason.LIMITED)
    assert (result.flow_rate_scale, result.speed_scale) == (flow, speed)


@pytest.mark.parametrize('limits', [(0.1, 1.2), (0.9, 10.0)])
@pytest.mark.parametrize('measured', [1.6e-3, 2.5e-3])
def test_no_factor_passes_its_limits(limits: tuple[float, float], measured: float) -> None:
    low, high = limits
    result = advice([measured] * 30, minimum_scale=low, maximum_scale=high)
    assert low <= result.flow_rate_scale <= high
    assert low <= result.speed_scale <= high


@pytest.mark.parametrize('measured', [1.95e-3, 2e-3, 2.05e-3])
def test_within_the_dead_band_nothing_changes(measured: float) -> None:
    result = advice([measured] * 30)
    assert (result.valid, result.reason) == (True, Reason.ON_TARGET)
    assert (result.flow_rate_scale, result.speed_scale) == (1, 1)


def test_just_outside_the_dead_band_something_does() -> None:
    assert advice([1.93e-3] * 30).reason is Reason.UNDER_EXTRUSION


def test_without_a_target_there_is_no_advice() -> None:
    result = advice([1e-3] * 30, target_thickness=0.0)
    assert_changes_nothing(result, Reason.NO_TARGET)
    assert np.isnan(result.target_thickness)
    assert result.measured_thickness == pytest.approx(1e-3)


def test_only_the_newest_stretch_counts() -> None:
    # Samples are 1 mm apart: 20.5 mm hold the last 21.
    result = advice([9e-3] * 30 + [1.6e-3] * 21, window=0.0205)
    assert result.measured_thickness == pytest.approx(1.6e-3)
    assert result.window == pytest.approx((29.5e-3, 50e-3))
    assert result.sample_count == 21


def test_the_window_ends_where_ink_was_last_to_be_laid() -> None:
    result = advice([1.6e-3] * 30 + [np.nan] * 30, [M] * 30 + [NO_DATA] * 30,
                    [True] * 30 + [False] * 30)
    assert result.window == pytest.approx((9e-3, 29e-3))
    assert result.reason is Reason.UNDER_EXTRUSION


def test_a_short_path_is_its_own_window() -> None:
    assert advice([1.6e-3] * 15).window == pytest.approx((0, 14e-3))


def test_the_median_ignores_less_than_half_wrong_samples() -> None:
    assert advice([1.6e-3] * 12 + [8e-3] * 9).measured_thickness == pytest.approx(1.6e-3)


@pytest.mark.parametrize(('count', 'enough'), [(9, False), (10, True)])
def test_few_samples_are_not_enough(count: int, enough: bool) -> None:
    result = advice([1.6e-3] * count)
    assert result.valid == enough
    assert result.sample_count == count
    if not enough:
        assert_changes_nothing(result, Reason.NOT_ENOUGH_DATA)


@pytest.mark.parametrize(('measured', 'enough'), [(10, False), (11, True)])
def test_little_coverage_is_not_enough(measured: int, enough: bool) -> None:
    status = ([M, NO_DATA] * 21)[:21] if measured == 11 else ([NO_DATA, M] * 21)[:21]
    assert status.count(M) == measured
    result = advice([1.6e-3 if s == M else np.nan for s in status], status)
    assert result.valid == enough


@pytest.mark.parametrize(('gap', 'alarm'), [(1, False), (2, True), (5, True)])
def test_ink_missing_over_some_length_is_an_alarm(gap: int, alarm: bool) -> None:
    status = [M] * 24 + [GAP] * gap + [M] * 3
    result = advice([1.6e-3 if s == M else 0 for s in status], status)
    if alarm:
        assert_changes_nothing(result, Reason.GAP_DETECTED)
    else:
        assert result.reason is Reason.UNDER_EXTRUSION


def test_a_gap_made_on_purpose_is_no_alarm() -> None:
    status = [M] * 15 + [GAP] * 5 + [M] * 10
    result = advice([1.6e-3 if s == M else 0 for s in status], status,
                    [s == M for s in status])
    assert (result.valid, result.reason) == (True, Reason.UNDER_EXTRUSION)


def test_a_gap_before_the_window_is_no_alarm() -> None:
    status = [GAP] * 10 + [M] * 30
    assert advice([1.6e-3 if s == M else 0 for s in status], status).valid


def test_a_window_of_nothing_but_gap_is_an_alarm() -> None:
    result = advice([0] * 30, [GAP] * 30)
    assert_changes_nothing(result, Reason.GAP_DETECTED)
    assert np.isnan(result.measured_thickness)
    assert np.isnan(result.measurement_age)


@pytest.mark.parametrize(('delay', 'stale'), [(19.9, False), (20.1, True)])
def test_old_measurements_are_stale(delay: float, stale: bool) -> None:
    result = advice([1.6e-3] * 30, delay=delay)
    assert result.measurement_age == pytest.approx(delay)
    assert result.valid == (not stale)
    if stale:
        assert_changes_nothing(result, Reason.STALE_DATA)


def test_without_any_ink_commanded_there_is_nothing_to_advise_on() -> None:
    result = advice([0] * 30, [GAP] * 30, [False] * 30)
    assert_changes_nothing(result, Reason.NOT_ENOUGH_DATA)
    assert np.isnan(result.window).all()


def test_an_empty_profile_is_not_enough() -> None:
    assert_changes_nothing(advice([]), Reason.NOT_ENOUGH_DATA)


def test_confidence_is_coverage_less_spread() -> None:
    # 10 of 20 measured, half at 1.5 and half at 1.7 mm: spread 0.1 / 1.6.
    status = [M, NO_DATA] * 10
    thickness = [(1.5e-3, np.nan, 1.7e-3, np.nan)[i % 4] for i in range(20)]
    assert advice(thickness, status).confidence == pytest.approx(0.5 * (1 - 0.1 / 1.6))


def test_advice_holds_for_its_lifetime() -> None:
    result = advice([1.6e-3] * 30, lifetime=7.5)
    assert result.valid_until_ns - result.stamp_ns == 7.5 * SECOND
    assert result.print_id == 'print'
