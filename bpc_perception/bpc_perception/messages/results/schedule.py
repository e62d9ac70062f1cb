"""Convert the schedule of a layer from and to messages."""

from __future__ import annotations

import numpy as np
from std_msgs.msg import Header

from bpc_interfaces.msg import RateSchedule as RateScheduleMsg
from bpc_perception.core.learning.layer_schedule import LayerSchedule, ScheduleReason
from bpc_perception.core.learning.rate_schedule import RateSchedule
from bpc_perception.messages.array_fields import (
    axes_fields,
    check_lengths,
    floats_field,
    points_of,
)
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp, stamp_to_ns

CURVES = 'place', 'factor', 'volume'
NUMBERS = 'sigma', 'level_sigma', 'reference', 'advance', 'retreat'


def schedule_to_message(told: LayerSchedule, frame_id: str) -> RateScheduleMsg:
    """Convert the schedule of a layer, with points in a frame, to a message."""
    schedule = told.schedule
    message = RateScheduleMsg(
        header=Header(stamp=ns_to_stamp(told.stamp_ns), frame_id=frame_id),
        print_id=told.print_id, layer=told.layer, valid=told.valid, reason=int(told.reason),
        **axes_fields('', told.points),
        **{name: float('nan') if schedule is None else getattr(schedule, name)
           for name in NUMBERS},
        source_print_id=[name for name, _ in told.based_on],
        source_layer=[layer for _, layer in told.based_on])
    if schedule is not None:
        for name in CURVES:
            setattr(message, name, floats_field(getattr(schedule, name)))
    return message


def schedule_from_message(message: RateScheduleMsg) -> LayerSchedule:
    """Convert a message. Raises ConversionError for values that no schedule has."""
    check_lengths('rate_schedule', message, (*CURVES, 'x', 'y', 'z'))
    check_lengths('rate_schedule', message, ('source_print_id', 'source_layer'))
    try:
        reason = ScheduleReason(message.reason)
    except ValueError:
        raise ConversionError(
            f'rate_schedule: expected a reason up to {max(ScheduleReason)}, found '
            f'{message.reason}; is its sender of another version?') from None
    return LayerSchedule(
        stamp_to_ns(message.header.stamp), message.print_id, message.layer, reason,
        _schedule(message) if message.valid else None, points_of(message, ''),
        tuple(zip(message.source_print_id, message.source_layer, strict=True)))


def _schedule(message: RateScheduleMsg) -> RateSchedule:
    place, factor, volume = (np.array(getattr(message, name)) for name in CURVES)
    if len(place) < 2 or not (np.diff(place) > 0).all():
        raise ConversionError('rate_schedule: expected two places or more in their order, found '
                              'others; is its sender bpc?')
    numbers = [getattr(message, name) for name in NUMBERS]
    if not ((factor > 0) & np.isfinite(factor)).all() or not np.isfinite(numbers).all():
        raise ConversionError('rate_schedule: expected factors above 0 and numbers that are '
                              'known, found others; is its sender bpc?')
    return RateSchedule(place=place, factor=factor, volume=volume,
                        layers=len(message.source_layer),
                        **dict(zip(NUMBERS, numbers, strict=True)))
