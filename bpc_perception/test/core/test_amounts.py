"""How much ink lies along a print, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from perception_builders import path_through, profile_of
import pytest

from bpc_perception.core.amounts import amount_of, commanded_area, LEAST_KNOWN, lengths
from bpc_perception.core.profile import Status, ThicknessProfile

MM = 1e-3
AREA = 2 * MM**2


def print_of(area: list[float]) -> ThicknessProfile:
    """Samples 1 mm apart of these areas [mm^2], of which 2 mm^2 were commanded."""
    values = np.array(area) * MM**2
    return replace(profile_of([2 * MM] * len(area)), area=values, area_sigma=0.01 * values,
                   height=values / (2 * MM), commanded_area=np.full(len(area), AREA))


def every(profile: ThicknessProfile) -> np.ndarray:
    return np.ones(len(profile), bool)


def test_volume_is_area_along_the_path() -> None:
    profile = print_of([1.0] * 10 + [3.0] * 10)
    amount = amount_of(profile, every(profile))
    assert amount.length == pytest.approx(20 * MM)
    assert amount.volume == pytest.approx(40 * MM**3)
    assert amount.commanded == pytest.approx(40 * MM**3)
    assert amount.delivered == pytest.approx(1)
    assert amount.known == 1
    assert amount.area == pytest.approx(AREA)
    assert 0.02 < amount.volume_sigma / amount.volume < 0.05


def test_a_part_is_told_by_itself() -> None:
    profile = print_of([1.0] * 10 + [3.0] * 10)
    half = np.arange(20) < 10
    assert amount_of(profile, half).volume == pytest.approx(10 * MM**3)
    assert amount_of(profile, half).delivered == pytest.approx(0.5)


def test_what_is_not_known_counts_as_the_rest_and_is_less_sure() -> None:
    profile = print_of([2.0] * 14 + [np.nan] * 6)
    amount = amount_of(profile, every(profile))
    assert amount.volume == pytest.approx(40 * MM**3)
    assert amount.known == pytest.approx(0.7)
    whole = print_of([2.0] * 20)
    assert amount.volume_sigma > amount_of(whole, every(whole)).volume_sigma


def test_less_than_half_known_is_no_volume() -> None:
    assert LEAST_KNOWN == 0.5
    profile = print_of([2.0] * 9 + [np.nan] * 11)
    amount = amount_of(profile, every(profile))
    assert np.isnan(amount.volume)
    assert np.isnan(amount.delivered)
    assert amount.area == pytest.approx(AREA)


def test_a_gap_holds_nothing() -> None:
    profile = print_of([2.0] * 10 + [0.0] * 10)
    profile = replace(profile, area_sigma=np.where(profile.area > 0, profile.area_sigma, np.nan),
                      status=np.repeat((Status.MEASURED, Status.GAP), 10).astype(np.uint8))
    amount = amount_of(profile, every(profile))
    assert amount.volume == pytest.approx(20 * MM**3)
    assert amount.area == pytest.approx(AREA)  # of the bead, where there is one


def test_travel_holds_no_ink_of_a_stroke() -> None:
    profile = replace(print_of([2.0] * 20), stroke=np.repeat((1, 0), 10))
    assert amount_of(profile, every(profile)).length == pytest.approx(10 * MM)


def test_an_empty_part_tells_nothing() -> None:
    profile = print_of([2.0] * 3)
    amount = amount_of(profile, ~every(profile))
    assert amount.length == 0
    assert np.isnan(amount.volume)
    assert np.isnan(amount.known)


def test_commanded_ink_follows_from_flow_and_time() -> None:
    """1e-8 m^3/s at 10 mm/s is 1 mm^2; where the nozzle is half as fast, it is twice as much."""
    path = path_through(np.column_stack((np.arange(20) * MM, np.zeros((20, 2)))), speed=0.01)
    stroke = np.repeat((1, 0), 10)
    area = commanded_area(path, stroke)
    np.testing.assert_allclose(area[:10], MM**2)
    np.testing.assert_array_equal(area[10:], 0)
    slow = replace(path, time=2 * path.time)
    np.testing.assert_allclose(commanded_area(slow, stroke)[:10], 2 * MM**2)
    unknown = replace(path, flow_rate=np.full(20, np.nan))
    assert np.isnan(commanded_area(unknown, stroke)[:10]).all()


def test_a_stroke_ends_half_a_step_behind_its_last_sample() -> None:
    arc = np.array((0.0, 1, 2, 10, 11, 30))
    stroke = np.array((1, 1, 1, 2, 2, 3))
    np.testing.assert_array_equal(lengths(arc, stroke), [1, 1, 1, 1, 1, 0])
