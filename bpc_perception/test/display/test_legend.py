"""Statuses, reasons and sides are told apart, by words and colours."""

from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.profile import Status
from bpc_perception.display.legend import (
    LEFT_COLOUR,
    RIGHT_COLOUR,
    STATUS_COLOURS,
    STATUS_SIGNS,
    WINDOW_COLOUR,
)
from bpc_perception.display.wording import MEANINGS, REASONS


def test_everything_has_words_and_a_colour_of_its_own():
    assert set(REASONS) == set(Reason)
    assert set(MEANINGS) == set(STATUS_COLOURS) == set(Status)
    colours = [*STATUS_COLOURS.values(), LEFT_COLOUR, RIGHT_COLOUR, WINDOW_COLOUR]
    assert len(set(colours)) == len(colours)


def test_everything_but_a_thickness_has_a_sign_of_its_own():
    assert set(STATUS_SIGNS) == set(Status) - {Status.MEASURED}
    assert len(set(STATUS_SIGNS.values())) == len(STATUS_SIGNS)
