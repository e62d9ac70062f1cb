"""Following advice: from the factor in force, once, and only as long as the advice holds."""

from __future__ import annotations

from typing import Any

import pytest

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_sim.closed_loop.controllers import AdviceFollower

SECOND_NS = 10**9


def advice(stamp: float, flow: float = 1.0, valid: bool = True, until: float | None = None,
           reference: float = 0.0) -> RateAdvice:
    return RateAdvice(
        round(stamp * SECOND_NS), 'print', valid,
        Reason.ON_TARGET if valid else Reason.GAP_DETECTED,
        2e-3, 2e-3, (0.0, 0.02), 100, flow, 1 / flow, 1.0, 1.0,
        round((stamp + 5 if until is None else until) * SECOND_NS), reference_time=reference)


def follow(follower: AdviceFollower, *messages: tuple[float, RateAdvice]) -> AdviceFollower:
    for time, message in messages:
        follower.take(None, message, round(time * SECOND_NS))
    return follower


def scale(follower: AdviceFollower, time: float) -> float:
    return follower.scale(round(time * SECOND_NS), 0.0)


@pytest.mark.parametrize(('actuator', 'factor'), [('flow', 1.25), ('speed', 0.8)])
def test_it_corrects_what_it_is_to_correct(actuator: str, factor: float) -> None:
    follower = follow(AdviceFollower(actuator), (2.0, advice(1.0, 1.25)))
    assert scale(follower, 1.9) == 1
    assert scale(follower, 2.0) == pytest.approx(factor)


def test_late_advice_is_on_what_was_in_force_at_its_stamp() -> None:
    # The second capture was taken before the first advice came: both say the same.
    follower = follow(AdviceFollower(), (2.0, advice(1.0, 1.25)), (2.5, advice(1.5, 1.25)))
    assert scale(follower, 2.6) == pytest.approx(1.25)
    # The third capture was taken after it: its advice multiplies 1.25.
    assert scale(follow(follower, (3.5, advice(2.6, 1.2))), 3.6) == pytest.approx(1.5)


def test_what_was_in_force_is_a_mean() -> None:
    follower = follow(AdviceFollower(), (2.0, advice(1.0, 1.5)))
    # Half of the second before the stamp at 1, half at 1.5.
    assert scale(follow(follower, (3.0, advice(2.5, 1.2, reference=1.0))), 3.1) == pytest.approx(
        1.25 * 1.2)


def test_advice_twice_is_advice_once() -> None:
    follower = follow(AdviceFollower(), (2.0, advice(1.0, 1.25)), (2.1, advice(1.0, 1.25)))
    assert scale(follower, 2.2) == pytest.approx(1.25)


def test_not_valid_changes_nothing_and_keeps_what_is_there() -> None:
    follower = follow(AdviceFollower(), (2.0, advice(1.0, 1.25)),
                      (4.0, advice(3.0, valid=False)))
    assert scale(follower, 7.9) == pytest.approx(1.25)
    assert scale(follower, 8.1) == 1


def test_when_nothing_holds_any_more_the_rate_is_nominal() -> None:
    follower = follow(AdviceFollower(), (2.0, advice(1.0, 1.25)))
    assert scale(follower, 6.0) == pytest.approx(1.25)
    assert scale(follower, 6.1) == 1
    # Later advice starts from the nominal rate.
    assert scale(follow(follower, (8.0, advice(7.0, 1.1))), 8.1) == pytest.approx(1.1)


def test_stale_advice_does_not_prolong() -> None:
    follower = follow(AdviceFollower(), (2.0, advice(1.0, 1.25)),
                      (5.0, advice(4.5, valid=False, until=6.0)))
    assert scale(follower, 6.1) == 1


def test_expired_advice_is_not_followed() -> None:
    assert scale(follow(AdviceFollower(), (7.0, advice(1.0, 1.25))), 7.1) == 1


def test_its_own_limits_are_not_passed() -> None:
    messages: list[tuple[float, Any]] = [(k + 0.5, advice(k, 1.5)) for k in range(1, 6)]
    assert scale(follow(AdviceFollower(), *messages), 6.0) == 2


def test_an_unknown_actuator_is_refused() -> None:
    with pytest.raises(ValueError, match='actuator: expected flow or speed, found heat'):
        AdviceFollower('heat')
