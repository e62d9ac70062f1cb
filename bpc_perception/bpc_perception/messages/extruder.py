"""Convert extruder states from and to messages."""

from __future__ import annotations

import math

import numpy as np
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.core.extruder.plunger import PlungerMotion
from bpc_perception.core.extruder.sample import ExtruderSample
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp, stamp_to_ns

# No syringe does more: 0.1 litre a second, 50 mm a second.
FASTEST_FLOW_M3_PER_S, FASTEST_PLUNGER_M_PER_S = 1e-4, 0.05


def extruder_from_message(message: ExtrusionState) -> ExtruderSample:
    """Return that part of the extruder's state that the path carries.

    After an error it is not known what the extruder does. Raises ConversionError for rates that
    are impossible.
    """
    for name, fastest, unit in (('flow_rate', FASTEST_FLOW_M3_PER_S, 'm^3/s'),
                                ('plunger_velocity', FASTEST_PLUNGER_M_PER_S, 'm/s')):
        if abs(getattr(message, name)) > fastest:  # NaN = unknown
            raise ConversionError(
                f'extrusion_state: expected a {name} of at most {fastest:g} {unit}, found '
                f'{getattr(message, name):g}; is it in millimetres?')
    if message.error_status:
        return ExtruderSample(stamp_to_ns(message.header.stamp), False, math.nan, math.nan)
    return ExtruderSample(stamp_to_ns(message.header.stamp), bool(message.extruding),
                          message.plunger_velocity, message.flow_rate)


def extruder_to_message(stamp_ns: int, motion: PlungerMotion,
                        error_status: int = 0) -> ExtrusionState:
    """Convert the extruder's state to a message."""
    return ExtrusionState(
        header=Header(stamp=ns_to_stamp(stamp_ns)), extruding=motion.extruding,
        plunger_velocity=motion.velocity, plunger_position=motion.position,
        flow_rate=motion.flow_rate, error_status=error_status,
        position_uncertain=motion.position_uncertain)


def joint_motion(message: JointState, joint: str) -> tuple[float, float]:
    """Return velocity [m/s] and position [m] of a prismatic joint; a position may be NaN.

    Raises ConversionError when the message has no such joint, or no velocity of it.
    """
    if joint not in message.name:
        raise ConversionError(f'{joint}: expected this joint, '
                              f'found {", ".join(message.name) or "none"}'
                              '; set plunger.joint to one of them')
    index = list(message.name).index(joint)
    velocity, position = (float(values[index]) if len(values) > index else float('nan')
                          for values in (message.velocity, message.position))
    if not np.isfinite(velocity):
        raise ConversionError(f'{joint}: expected a velocity, found none'
                              '; let its driver publish it')
    return velocity, position
