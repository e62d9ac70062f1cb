"""A print beside its design from and to messages, and which messages are refused."""

from __future__ import annotations

from typing import Any

from design_builders import lattice, path_of, printed, profile_along, snake
import numpy as np
from perception_builders import pose
import pytest

from bpc_perception.core.design.comparison import (
    compare_with_design,
    DesignFindings,
    WantedDesign,
)
from bpc_perception.core.design.design import Design
from bpc_perception.messages.results.design import (
    design_from_message,
    design_to_message,
    no_design,
)
from bpc_perception.messages.stamps import ConversionError

pytestmark = pytest.mark.ros
PLACE = pose((0.5, -0.1, 0.02), (40, 1, 0))


def findings(design: Design, wanted: Design, share: float = 0.6) -> DesignFindings:
    points, stroke = printed(design, PLACE, share * design.length, left_out=(1,))
    return compare_with_design(profile_along(points, stroke), WantedDesign('vase.csv', wanted),
                               path_of(points, stroke, False)).findings


@pytest.mark.parametrize('found', [findings(lattice(layers=2), lattice(layers=2)),
                                   findings(snake(), lattice(), 1.0)],
                         ids=['found', 'refused'])
def test_it_survives_there_and_back(found: DesignFindings) -> None:
    message = design_to_message(found, 'print', 5, 'base')
    assert (message.print_id, message.header.frame_id) == ('print', 'base')
    back = design_from_message(message)
    place, other = found.registration, back.registration
    assert (other.refusal, bool(other.refusal)) == (place.refusal, not found.layers)
    np.testing.assert_allclose(other.T_base_design, place.T_base_design, atol=1e-12)
    np.testing.assert_equal((other.residual, other.explained, other.scale),
                            (place.residual, place.explained, place.scale))
    np.testing.assert_array_equal(back.surplus, found.surplus)
    for name in ('name', 'layers', 'missing', 'nozzle', 'bead', 'width'):
        assert repr(getattr(back, name)) == repr(getattr(found, name))


def test_that_there_is_no_print_is_told() -> None:
    message = no_design(5, 'base')
    assert (message.print_id, len(message.layer_number)) == ('', 0)


@pytest.mark.parametrize(('field', 'value', 'words'), [
    ('missing_presence', [7], '7 is not a valid Presence'),
    ('missing_end', [], 'arrays of one length'),
    ('layer_known', [1, 2, 3], 'arrays of one length'),
    ('surplus_end', [1.0], 'arrays of one length')])
def test_impossible_messages_are_refused(field: str, value: Any, words: str) -> None:
    message = design_to_message(findings(lattice(), lattice()), 'print', 5, 'base')
    if field == 'missing_presence':
        value = value * len(message.missing_stroke)
    setattr(message, field, value)
    with pytest.raises(ConversionError, match=words):
        design_from_message(message)


def test_a_turn_that_is_none_is_refused() -> None:
    message = design_to_message(findings(lattice(), lattice()), 'print', 5, 'base')
    message.pose.orientation.x = float('nan')
    with pytest.raises(ConversionError, match='expected a turn as quaternion'):
        design_from_message(message)
