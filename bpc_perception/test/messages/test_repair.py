"""Plans of repair from and to messages, and which messages are refused."""

from __future__ import annotations

from dataclasses import astuple
from typing import Any

import numpy as np
import pytest
from repair_builders import plan, with_gap, with_status

from bpc_perception.core.profile import Status
from bpc_perception.core.repair.plan import RepairPlan
from bpc_perception.messages.results.repair import repair_from_message, repair_to_message
from bpc_perception.messages.stamps import ConversionError

pytestmark = pytest.mark.ros


def mended() -> RepairPlan:
    """A plan with two gaps to fill and one whose end is hidden."""
    profile = with_gap(150, 170, with_gap(60, 75, with_gap(100, 120)))
    return plan(with_status(profile, Status.OCCLUDED, (170, 180)), laying=False)


@pytest.mark.parametrize('made', [mended(), RepairPlan.none(5)], ids=['print', 'none'])
def test_a_plan_survives_there_and_back(made: RepairPlan) -> None:
    message = repair_to_message(made, 'base')
    assert message.header.frame_id == 'base'
    back = repair_from_message(message)
    assert (back.stamp_ns, back.print_id, back.laying) == (made.stamp_ns, made.print_id,
                                                           made.laying)
    for layer, other in zip(made.layers, back.layers, strict=True):
        assert (other.number, other.finished, other.state, other.unfilled) == (
            layer.number, layer.finished, layer.state, layer.unfilled)
        for fill, again in zip(layer.fills, other.fills, strict=True):
            for one, two in zip(astuple(fill), astuple(again), strict=True):
                np.testing.assert_array_equal(one, two)


def test_a_message_has_the_points_of_all_strokes_and_their_flow() -> None:
    made = mended()
    assert (len(made.fills), len(made.layers[0].unfilled)) == (2, 1)
    message = repair_to_message(made, 'base')
    first, second = message.fill_points
    np.testing.assert_allclose(message.point_x[:first], made.fills[0].arc_length)
    np.testing.assert_allclose(message.point_x[first:first + second], made.fills[1].arc_length)
    np.testing.assert_allclose(message.point_flow[first:], made.fills[1].flow)
    # The volume of a stroke is what flows while the nozzle passes.
    for number, part in enumerate((slice(0, first), slice(first, first + second))):
        lasts = np.diff(message.point_arc_length[part]) / message.fill_speed[number]
        assert np.dot(message.point_flow[part][:-1], lasts) == pytest.approx(
            message.fill_volume[number])


@pytest.mark.parametrize(('field', 'value', 'words'), [
    ('layer_next', [9], '9 is not a valid NextLayer'), ('obstacle', [42], 'arrays of one length'),
    ('obstacle', [42, 0], '42 is not a valid Obstacle'),
    ('fill_kind', [7, 0], '7 is not a valid FillKind'),
    ('unfilled_reason', [77], '77 is not a valid NotFilled'),
    ('fill_speed', [1.0], 'arrays of one length'), ('point_y', [1.0], 'arrays of one length'),
    ('fill_points', [1, 2], 'expected 3 points of its strokes')])
def test_impossible_plans_are_refused(field: str, value: Any, words: str) -> None:
    message = repair_to_message(mended(), 'base')
    setattr(message, field, value)
    with pytest.raises(ConversionError, match=words):
        repair_from_message(message)
