"""How statuses, advice and numbers are said."""

from __future__ import annotations

from dataclasses import replace
import math

import numpy as np
from perception_builders import advice_of, profile_of
import pytest

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.profile import Cause, Status
from bpc_perception.display.wording import (
    advice_headline,
    advice_in_a_line,
    advice_in_words,
    age_in_words,
    cause_counts,
    cause_in_words,
    CAUSES,
    in_mm,
    lost_in_words,
)


@pytest.mark.parametrize(('valid', 'reason', 'words'), [
    (False, Reason.GAP_DETECTED, 'change nothing: gap detected'),
    (True, Reason.ON_TARGET, 'change nothing: on target'),
    (True, Reason.LIMITED, 'flow x 2.00, or else speed x 0.50: '
                           'limited to the largest change allowed')])
def test_advice_in_words(valid: bool, reason: Reason, words: str) -> None:
    advice = RateAdvice(0, '', valid, reason, 1.0, 1.0, (0.0, 1.0), 1, 2.0, 0.5, 1.0, 0.0, 0)
    assert advice_in_words(advice) == words


@pytest.mark.parametrize(('expected', 'said'), [
    (0.65, 'wider than wanted, of no more ink'), (0.3, 'narrower than wanted, of no less ink'),
    (0.401, 'as wide as wanted'), (math.nan, 'as wide as wanted')])
def test_where_width_and_volume_disagree_it_is_not_said_to_be_on_target(
        expected: float, said: str) -> None:
    """0.65 mm wide instead of 0.4 mm, and its volume is right: the verdict says thick."""
    advice = replace(advice_of(Reason.VOLUME_DISAGREES), by_volume=True, target_thickness=0.4e-3,
                     expected_thickness=expected * 1e-3, flow_rate_scale=1.0, speed_scale=1.0)
    told = (advice_in_words(advice), advice_in_a_line(advice), advice_headline(advice, 0).reason)
    assert ['on target' not in words for words in told] == [True] * 3
    assert [said in words for words in told] == [True] * 3
    assert advice_headline(advice, 0).headline == 'keep as it is'


@pytest.mark.parametrize(('rate', 'said'), [(0.0123, True), (0.0, False), (math.nan, False)])
def test_how_much_ink_spreads_is_said(rate: float, said: bool) -> None:
    advice = replace(advice_of(Reason.OVER_EXTRUSION), spreading=rate)
    told = (advice_in_words(advice), advice_in_a_line(advice), advice_headline(advice, 0).reason)
    assert ['laid ink widens by 1.2% a second' in words for words in told] == [said] * 3


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


def test_every_cause_is_said() -> None:
    assert list(CAUSES) == list(Cause)
    assert cause_in_words(Cause.OLD_INK) == 'ink lay there before: clean the bed'
    assert cause_in_words(Cause.OVER_STROKE) == 'travel over a stroke: the ink is of the stroke'


def test_causes_are_counted_the_most_frequent_first() -> None:
    cause = np.array((Cause.NONE, Cause.NO_DEPTH, Cause.GLARE, Cause.GLARE), np.uint8)
    profile = replace(profile_of([math.nan] * 4, [Status.MEASURED, Status.NO_DATA,
                                                  Status.LOW_CONFIDENCE, Status.LOW_CONFIDENCE]),
                      cause=cause)
    assert list(cause_counts(profile).items()) == [(Cause.GLARE, 2), (Cause.NO_DEPTH, 1)]


@pytest.mark.parametrize(('lost', 'words'), [
    (2, '20% of the strokes are not known; of these 100%: ink lay there before: clean the bed'),
    (1, '')])
def test_it_is_said_why_much_is_not_known(lost: int, words: str) -> None:
    statuses = [Status.MEASURED] * (10 - lost) + [Status.LOW_CONFIDENCE] * lost
    profile = profile_of([2e-3] * 10, statuses)
    cause = np.where(profile.status == Status.MEASURED, Cause.NONE, Cause.OLD_INK)
    assert lost_in_words(replace(profile, cause=cause.astype(np.uint8))) == words
