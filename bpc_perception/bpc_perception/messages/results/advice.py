"""Convert rate advice from and to messages."""

from __future__ import annotations

from typing import Any

import numpy as np
from std_msgs.msg import Header

from bpc_interfaces.msg import RateAdvice as RateAdviceMsg
from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp, stamp_to_ns

# Fields that have the same name in both forms.
SHARED_FIELDS = ('reference_time', 'expected_thickness', 'delivery', 'delivery_sigma', 'lag',
                 'lag_sigma', 'flow_rate', 'plunger_velocity', 'speed')
# Older recordings have none of these.
NEWER_FIELDS: dict[str, Any] = {'by_volume': False, 'measured_area': float('nan'),
                                'spreading': float('nan')}


def advice_to_message(advice: RateAdvice) -> RateAdviceMsg:
    """Convert advice to a message."""
    return RateAdviceMsg(
        header=Header(stamp=ns_to_stamp(advice.stamp_ns)), print_id=advice.print_id,
        valid=advice.valid, reason=int(advice.reason), target_thickness=advice.target_thickness,
        measured_thickness=advice.measured_thickness, window_start=advice.window[0],
        window_end=advice.window[1], sample_count=advice.sample_count,
        flow_rate_scale=advice.flow_rate_scale, speed_scale=advice.speed_scale,
        confidence=advice.confidence, measurement_age=advice.measurement_age,
        valid_until=ns_to_stamp(advice.valid_until_ns),
        **{name: getattr(advice, name) for name in (*SHARED_FIELDS, *NEWER_FIELDS)})


def advice_from_message(message: RateAdviceMsg) -> RateAdvice:
    """Convert advice from its message. Raises ConversionError for values that no advice has."""
    if message.reason not in list(Reason):
        raise ConversionError(f'rate_advice: expected a reason up to {max(Reason)}, '
                              f'found {message.reason}; is its sender of another version?')
    for name in ('flow_rate_scale', 'speed_scale'):
        if not 0 < getattr(message, name) < np.inf:
            raise ConversionError(f'rate_advice: expected a {name} above 0, '
                                  f'found {getattr(message, name)}; is its sender bpc?')
    return RateAdvice(
        stamp_ns=stamp_to_ns(message.header.stamp), print_id=message.print_id,
        valid=bool(message.valid), reason=Reason(message.reason),
        target_thickness=message.target_thickness,
        measured_thickness=message.measured_thickness,
        window=(message.window_start, message.window_end), sample_count=message.sample_count,
        flow_rate_scale=message.flow_rate_scale, speed_scale=message.speed_scale,
        confidence=message.confidence, measurement_age=message.measurement_age,
        valid_until_ns=stamp_to_ns(message.valid_until),
        **{name: getattr(message, name) for name in SHARED_FIELDS},
        **{name: getattr(message, name, default) for name, default in NEWER_FIELDS.items()})
