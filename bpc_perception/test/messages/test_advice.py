"""Advice from and to messages, field by field, and which messages are refused."""

from __future__ import annotations

from message_builders import assert_same, refused, STAMP_NS
import pytest

from bpc_interfaces.msg import RateAdvice as RateAdviceMsg
from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.messages.results.advice import advice_from_message, advice_to_message

pytestmark = pytest.mark.ros
ADVICE = RateAdvice(
    stamp_ns=STAMP_NS, print_id='print', valid=True, reason=Reason.LIMITED, target_thickness=2e-3,
    measured_thickness=1e-3, window=(0.01, 0.03), sample_count=17, flow_rate_scale=2.0,
    speed_scale=0.5, confidence=0.75, measurement_age=1.5, valid_until_ns=STAMP_NS + 5,
    reference_time=0.25, expected_thickness=1.1e-3, delivery=0.9, delivery_sigma=0.1, lag=2.0,
    lag_sigma=0.5, flow_rate=1e-9, plunger_velocity=1e-5, speed=3e-3)


def test_advice_survives_there_and_back() -> None:
    assert_same(advice_from_message(advice_to_message(ADVICE)), ADVICE)


def test_an_unknown_reason_is_refused() -> None:
    message = advice_to_message(ADVICE)
    message.reason = 99
    with refused:
        advice_from_message(message)


@pytest.mark.parametrize('reason', list(Reason))
def test_reasons_are_those_of_the_message(reason: Reason) -> None:
    assert getattr(RateAdviceMsg, reason.name) == reason
