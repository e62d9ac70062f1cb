"""Statuses, reasons and sides are told apart, by words and colours."""

from dataclasses import replace

import numpy as np
from perception_builders import profile_of

from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.profile import Status
from bpc_perception.display.legend import (
    as_shown,
    LEFT_COLOUR,
    RIGHT_COLOUR,
    STATUS_COLOURS,
    STATUS_SIGNS,
    WINDOW_COLOUR,
)
from bpc_perception.display.wording import label, MEANINGS, REASONS


def test_everything_has_words_and_a_colour_of_its_own():
    assert set(REASONS) == set(Reason)
    assert set(MEANINGS) == set(STATUS_COLOURS) == set(Status)
    colours = [*STATUS_COLOURS.values(), LEFT_COLOUR, RIGHT_COLOUR, WINDOW_COLOUR]
    assert len(set(colours)) == len(colours)


def test_travel_is_drawn_alike_unless_there_is_ooze():
    unknown = [Status.BARE, Status.LOW_CONFIDENCE, Status.NO_DATA, Status.OCCLUDED, Status.OOZE]
    profile = profile_of([0.002] * 10, [Status.MEASURED, Status.GAP, *unknown[1:4], *unknown])
    travel = replace(profile, stroke=np.repeat((1, 0), 5))
    assert as_shown(travel).status.tolist() == [
        *profile.status[:5].tolist(), *[Status.BARE] * 4, Status.OOZE]
    assert [label(status) for status in (Status.BARE, Status.OOZE)] == ['travel', 'ooze']


def test_everything_but_a_thickness_has_a_sign_of_its_own():
    assert set(STATUS_SIGNS) == set(Status) - {Status.MEASURED}
    assert len(set(STATUS_SIGNS.values())) == len(STATUS_SIGNS)
