"""The schedule of a layer from and to messages, and which messages are refused."""

from __future__ import annotations

from typing import Any

import numpy as np
from perception_builders import START_NS
import pytest

from bpc_interfaces.msg import RateSchedule as RateScheduleMsg
from bpc_perception.core.learning.layer_schedule import LayerSchedule, ScheduleReason
from bpc_perception.core.learning.rate_schedule import RateSchedule
from bpc_perception.messages.results.schedule import schedule_from_message, schedule_to_message
from bpc_perception.messages.stamps import ConversionError

pytestmark = pytest.mark.ros
SCHEDULE = RateSchedule(
    place=np.array((0.0, 0.01, 0.02)), factor=np.array((1.2, 0.9, 1.0)), sigma=0.03,
    level_sigma=0.01, volume=np.array((1.2e-6, 0.9e-6, 1e-6)), reference=1e-6, advance=0.2,
    retreat=0.1, layers=2)
TOLD = LayerSchedule(START_NS, 'print', 2, ScheduleReason.LEARNED, SCHEDULE,
                     np.arange(9.0).reshape(3, 3), (('print', 0), ('print', 1)))


def test_it_survives_there_and_back() -> None:
    message = schedule_to_message(TOLD, 'base')
    assert (message.header.frame_id, message.valid, message.layer) == ('base', True, 2)
    back = schedule_from_message(message)
    assert (back.stamp_ns, back.print_id, back.layer, back.reason, back.based_on) == (
        TOLD.stamp_ns, TOLD.print_id, TOLD.layer, TOLD.reason, TOLD.based_on)
    np.testing.assert_array_equal(back.points, TOLD.points)
    assert back.schedule is not None
    for name in vars(SCHEDULE):
        np.testing.assert_array_equal(getattr(back.schedule, name), getattr(SCHEDULE, name))


@pytest.mark.parametrize('reason', [one for one in ScheduleReason if one])
def test_where_there_is_none_there_are_no_factors(reason: ScheduleReason) -> None:
    message = schedule_to_message(LayerSchedule.none(START_NS, 'print', 1, reason), 'base')
    assert (message.valid, len(message.factor), np.isnan(message.reference)) == (False, 0, True)
    back = schedule_from_message(message)
    assert (back.valid, back.reason, back.schedule) == (False, reason, None)


def test_the_reasons_are_those_of_the_message() -> None:
    assert {one.name: int(one) for one in ScheduleReason} == {
        one.name: getattr(RateScheduleMsg, one.name) for one in ScheduleReason}


@pytest.mark.parametrize(('field', 'value', 'words'), [
    ('factor', [1.2, 0.0, 1.0], 'factors above 0'),
    ('factor', [1.2, -1.0, 1.0], 'factors above 0'),
    ('factor', [1.2, np.nan, 1.0], 'factors above 0'),
    ('factor', [1.2, np.inf, 1.0], 'factors above 0'), ('factor', [1.2], 'one length'),
    ('place', [0.0, 0.02, 0.01], 'in their order'), ('x', [], 'one length'),
    ('advance', np.nan, 'that are known'), ('reason', 200, 'a reason up to 5'),
    ('source_layer', [1], 'one length')])
def test_what_no_schedule_has_is_refused(field: str, value: Any, words: str) -> None:
    message = schedule_to_message(TOLD, 'base')
    setattr(message, field, value)
    with pytest.raises(ConversionError, match=words):
        schedule_from_message(message)
