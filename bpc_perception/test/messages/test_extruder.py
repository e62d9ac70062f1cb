"""Extruder states from messages."""

from __future__ import annotations

from message_builders import NAN, STAMP_NS
import numpy as np
import pytest

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.messages.extruder import extruder_from_message
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp

pytestmark = pytest.mark.ros


def test_what_an_extruder_in_error_does_is_unknown() -> None:
    message = ExtrusionState(extruding=True, plunger_velocity=1e-4, flow_rate=5e-8,
                             error_status=1 << 6)
    sample = extruder_from_message(message)
    assert not sample.extruding
    assert np.isnan((sample.plunger_velocity, sample.flow_rate)).all()


def test_an_extruder_that_is_uncertain_of_its_position_is_believed() -> None:
    """The path carries velocity and flow, which do not depend on it."""
    message = ExtrusionState(extruding=True, plunger_velocity=1e-4, flow_rate=5e-8,
                             position_uncertain=True)
    sample = extruder_from_message(message)
    assert (sample.extruding, sample.plunger_velocity, sample.flow_rate) == (True, 1e-4, 5e-8)


@pytest.mark.parametrize('rates', [
    {'flow_rate': 12.0}, {'flow_rate': np.inf}, {'plunger_velocity': -0.1},
    {'plunger_velocity': np.inf}])
def test_rates_that_no_syringe_reaches_are_refused(rates: dict[str, float]) -> None:
    with pytest.raises(ConversionError, match=f'expected a {next(iter(rates))} of at most .*'
                                              'is it in millimetres'):
        extruder_from_message(ExtrusionState(extruding=True, **rates))


def test_an_extruder_state_is_read() -> None:
    message = ExtrusionState(extruding=True, plunger_velocity=2e-4, flow_rate=NAN)
    message.header.stamp = ns_to_stamp(STAMP_NS)
    sample = extruder_from_message(message)
    assert (sample.stamp_ns, sample.extruding, sample.plunger_velocity) == (STAMP_NS, True, 2e-4)
    assert np.isnan(sample.flow_rate)
