"""Ink that widens after it was laid: noticed by looking again, and not followed.

Truth by geometry: a bead of share g of the ink that was asked for, laid at age 0, is
w = w0 sqrt(g) (1 + growth(age)) wide, and its area stays: it becomes lower.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from perception_builders import path_through, profile_of, SECOND, START_NS
import pytest

from bpc_perception.core.advice.advisor import Advisor
from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.arrays import Array
from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.profile import ThicknessProfile

TARGET, FLOW, SPEED, SPACING = 2e-3, 1e-8, 0.01, 2e-4
PERIOD = 2.0
CONFIG = AdviceConfig(target_thickness=TARGET, slew_rate=100, acquisition_time=0)
NOISE = 0.01
Growth = Callable[[Array], Array]


def spreads(age: Array) -> Array:
    """A fifth in the long run, half of that within three seconds."""
    return 0.2 * age / (age + 3.0)


def stays(age: Array) -> Array:
    return np.zeros(len(age))


def look(number: int, share: float, growth: Growth, rng: np.random.Generator, *,
         area: float = np.nan, later_area: float = np.nan, one_sided: bool = False,
         ) -> tuple[Any, ThicknessProfile]:
    """The path up to a capture, and what is seen in it: all of the path is looked at again."""
    count = round(PERIOD * (number + 1) * SPEED / SPACING)
    points = np.column_stack((SPACING * np.arange(count), np.zeros((count, 2))))
    path = replace(path_through(points, speed=SPEED), flow_rate=np.full(count, FLOW))
    stamp = path.time[-1] + 0.1
    age = stamp - path.time
    laid = TARGET * np.sqrt(share)
    wide = laid * (1 + growth(age)) * (1 + NOISE * rng.normal(size=count))
    profile = profile_of(wide.tolist(), spacing=SPACING)
    old = age > PERIOD
    return path, replace(
        profile, stamp_ns=START_NS + round(stamp * SECOND), print_id=path.print_id,
        capture=number, seen_in=np.full(count, number), time=path.time,
        sigma=np.full(count, NOISE * laid),
        left=wide - laid / 2 if one_sided else wide / 2,
        right=np.full(count, laid / 2) if one_sided else wide / 2,
        area=np.where(old & np.isfinite(later_area), later_area, area) * np.ones(count),
        area_sigma=np.full(count, 0.02 * area))


def advised(share: float, growth: Growth, captures: int = 6, seed: int = 1,
            **looking: Any) -> RateAdvice:
    """The advice after so many captures."""
    advisor, rng = Advisor(), np.random.default_rng(seed)
    for number in range(captures):
        path, profile = look(number, share, growth, rng, **looking)
        advice = advisor.advise(profile, path, CONFIG)
    return advice


def first_widths(share: float) -> tuple[float, float]:
    """The widths of the youngest and of the oldest ink that is seen for the first time."""
    young, old = TARGET * np.sqrt(share) * (1 + spreads(np.array((0.1, 0.1 + PERIOD))))
    return float(young), float(old)


def test_ink_that_stays_does_not_spread() -> None:
    advice = advised(1.0, stays)
    assert advice.spreading == 0
    assert advice.reason == Reason.ON_TARGET


def test_how_much_it_spreads_is_told() -> None:
    """Since the capture in which it was seen first, the median sample widened by so much."""
    age = np.arange(0.1, 6 * PERIOD, SPACING / SPEED)
    first = (age - 0.1) % PERIOD + 0.1
    again = age > PERIOD + 0.1
    true = np.median((np.log((1 + spreads(age)) / (1 + spreads(first))) / np.maximum(
        age - first, 1e-9))[again])
    assert advised(1.0, spreads).spreading == pytest.approx(true, rel=0.1)


@pytest.mark.parametrize('share', [0.8, 1.0, 1.25])
def test_the_width_is_held_to_the_target_as_it_was_seen_first(share: float) -> None:
    """Ten seconds later it is more than a tenth wider."""
    advice = advised(share, spreads, captures=7)
    young, old = first_widths(share)
    assert young < advice.expected_thickness < old
    assert young < advice.measured_thickness < old
    assert advice.flow_rate_scale == pytest.approx((TARGET / advice.expected_thickness)**2,
                                                   rel=0.03)


def test_spreading_is_not_followed_from_capture_to_capture() -> None:
    """The longer one looks at ink, the wider it is: that asks for nothing."""
    factors = [advised(1.0, spreads, captures).flow_rate_scale for captures in range(2, 9)]
    assert max(factors) - min(factors) < 0.03


@pytest.mark.parametrize('share', [0.8, 1.25])
def test_where_the_area_is_known_it_says_how_much_ink_there_is(share: float) -> None:
    """Wider than wanted for its age, but of exactly the ink wanted, or of another amount."""
    advice = advised(1.0, spreads, area=FLOW / SPEED)
    assert advice.by_volume
    assert advice.flow_rate_scale == 1
    assert advice.reason == Reason.VOLUME_DISAGREES
    advice = advised(share, spreads, area=share * FLOW / SPEED)
    assert advice.by_volume
    assert advice.flow_rate_scale == pytest.approx(1 / share, rel=0.03)


def test_ink_that_had_been_hidden_does_not_spread() -> None:
    """Its area grows as its width does, or one edge alone goes out."""
    grown = FLOW / SPEED * 1.15
    assert advised(1.0, spreads, area=FLOW / SPEED, later_area=grown).spreading == 0
    assert advised(1.0, spreads, one_sided=True).spreading == 0


def test_one_look_tells_nothing() -> None:
    assert np.isnan(advised(1.0, spreads, captures=1).spreading)
