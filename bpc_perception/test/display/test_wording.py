"""How statuses, advice and numbers are said."""

from __future__ import annotations

import math

from perception_builders import advice_of
import pytest

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.display.wording import advice_headline, advice_in_words, age_in_words, in_mm


@pytest.mark.parametrize(('valid', 'reason', 'words'), [
    (False, Reason.GAP_DETECTED, 'change nothing: gap detected'),
    (True, Reason.ON_TARGET, 'change nothing: on target'),
    (True, Reason.LIMITED, 'flow x 2.00, or else speed x 0.50: '
                           'limited to the largest change allowed')])
def test_advice_in_words(valid: bool, reason: Reason, words: str) -> None:
    advice = RateAdvice(0, '', valid, reason, 1.0, 1.0, (0.0, 1.0), 1, 2.0, 0.5, 1.0, 0.0, 0)
    assert advice_in_words(advice) == words


@pytest.mark.parametrize(('given', 'headline', 'tone'), [
    (None, 'no advice yet', 'old'),
    (advice_of(Reason.OVER_EXTRUSION), 'flow × 0.83', 'act'),
    (advice_of(Reason.ON_TARGET), 'keep as it is', 'good'),
    (advice_of(Reason.NOT_ENOUGH_DATA, valid=False), 'change nothing', 'old'),
    (advice_of(Reason.CLOG_SUSPECTED, valid=False), 'alarm', 'bad'),
    (advice_of(Reason.OVER_EXTRUSION, valid_until_ns=10**9), 'expired', 'old')])
def test_advice_is_told_with_its_tone(given: RateAdvice | None, headline: str,
                                      tone: str) -> None:
    shown = advice_headline(given, 2 * 10**9)
    assert (shown.headline, shown.tone) == (headline, tone)
    assert shown.reason


def test_expired_advice_tells_what_it_was() -> None:
    expired = advice_headline(advice_of(Reason.OVER_EXTRUSION), 6 * 10**9)
    assert expired.otherwise == 'was: flow × 0.83'


def test_an_alarm_says_what_it_is() -> None:
    alarm = advice_headline(advice_of(Reason.GAP_DETECTED, valid=False), 0)
    assert alarm.otherwise == 'gap detected'


def test_what_is_not_known_is_no_number() -> None:
    assert in_mm(math.nan) == '–'
    assert in_mm(2.004e-3) == '2.00'
    assert [age_in_words(age) for age in (-1, 3.4, 119, 600)] == ['0 s', '3 s', '119 s', '10 min']
