"""Convert thickness profiles from and to messages."""

from __future__ import annotations

from array import array
from typing import Any

import numpy as np
from numpy.typing import NDArray
from std_msgs.msg import Header

from bpc_interfaces.msg import (
    ThicknessProfile as ThicknessProfileMsg,
    ThicknessProfileUpdate as ThicknessProfileUpdateMsg,
)
from bpc_perception.core.arrays import Index
from bpc_perception.core.growing_profile import ProfileChange
from bpc_perception.core.profile import Cause, Status, ThicknessProfile
from bpc_perception.core.stroke_ends import Strokes
from bpc_perception.messages.array_fields import (
    axes_fields,
    check_lengths,
    floats_field,
    points_of,
)
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp, stamp_to_ns

SIZES = 'height', 'height_sigma', 'area', 'area_sigma', 'commanded_area'
# Arrays with one element a sample that older recordings do not have.
NEWER = 'extruder_known', 'stroke', 'layer', 'seen_in', 'cause', *SIZES
# Arrays with one element a stroke; older recordings have none.
STROKE_FIELDS = 'stroke_number', 'stroke_start', 'stroke_end', 'ink_start', 'ink_end'


def profile_to_message(profile: ThicknessProfile, frame_id: str) -> ThicknessProfileMsg:
    """Convert a profile in the robot base frame, named ``frame_id``, to a message."""
    return _to_message(profile, profile, frame_id)


def change_to_message(change: ProfileChange, whole: ThicknessProfile,
                      frame_id: str) -> ThicknessProfileUpdateMsg:
    """Convert what changed in a profile, and the whole that it is now, to a message."""
    return ThicknessProfileUpdateMsg(base=ns_to_stamp(change.base_ns),
                                     index=_numbers_field(change.index),
                                     profile=_to_message(change.part, whole, frame_id))


def _to_message(part: ThicknessProfile, whole: ThicknessProfile,
                frame_id: str) -> ThicknessProfileMsg:
    """Convert the samples of a part, and what is said of the whole."""
    summary = whole.summary
    return ThicknessProfileMsg(
        header=Header(stamp=ns_to_stamp(whole.stamp_ns), frame_id=frame_id),
        print_id=whole.print_id, print_start=ns_to_stamp(whole.print_start_ns),
        capture=whole.capture, method=whole.method, time=floats_field(part.time),
        arc_length=floats_field(part.arc_length), **axes_fields('', part.points),
        extruding=part.extruding.tolist(), status=array('B', part.status.tobytes()),
        thickness=floats_field(part.thickness), thickness_sigma=floats_field(part.sigma),
        left=floats_field(part.left), right=floats_field(part.right),
        **axes_fields('left_', part.left_points), **axes_fields('right_', part.right_points),
        thickness_mean=summary.thickness_mean, thickness_std=summary.thickness_std,
        thickness_q1=summary.thickness_q1, thickness_median=summary.thickness_median,
        thickness_q3=summary.thickness_q3, coverage=summary.coverage,
        gap_count=summary.gap_count, gap_length=summary.gap_length,
        offset_mean=summary.offset_mean, offset_rms=summary.offset_rms,
        processing_time=whole.processing_time,
        extruder_known=part.extruder_known.tolist(), stroke=_numbers_field(part.stroke),
        ooze_count=summary.ooze_count, ooze_length=summary.ooze_length,
        bare_length=summary.bare_length, **_strokes_fields(whole.strokes),
        layer=_signed_field(part.layer), seen_in=_signed_field(part.seen_in),
        cause=array('B', part.cause.tobytes()), shift=whole.shift, tip_height=whole.tip_height,
        **{name: floats_field(getattr(part, name)) for name in SIZES})


def _strokes_fields(strokes: Strokes) -> dict[str, Any]:
    return {'stroke_number': _numbers_field(strokes.number),
            'stroke_start': floats_field(strokes.commanded[:, 0]),
            'stroke_end': floats_field(strokes.commanded[:, 1]),
            'ink_start': floats_field(strokes.ink[:, 0]),
            'ink_end': floats_field(strokes.ink[:, 1])}


def _numbers_field(numbers: Index) -> array[int]:
    """Return numbers (N,) in the type that a field uint32[] takes fastest."""
    return array('I', numbers.astype(np.uint32).tobytes())


def _signed_field(numbers: Index) -> array[int]:
    """Return numbers (N,) in the type that a field int32[] takes fastest."""
    return array('i', numbers.astype(np.int32).tobytes())


def _of_each_sample(message: ThicknessProfileMsg, name: str, kind: type,
                    default: float) -> NDArray[Any]:
    """Return an array (N,) that older recordings do not have."""
    values = getattr(message, name, ())
    return np.array(values, kind) if len(values) else np.full(len(message.time), default, kind)


def profile_from_message(message: ThicknessProfileMsg) -> ThicknessProfile:
    """Convert a profile from its message. Raises ConversionError for impossible values."""
    axes = [side + axis for side in ('', 'left_', 'right_') for axis in 'xyz']
    check_lengths('thickness_profile', message, (
        'time', 'arc_length', *axes, 'extruding', 'status', 'thickness', 'thickness_sigma',
        'left', 'right'))
    strokes = [name for name in STROKE_FIELDS if hasattr(message, name)]
    check_lengths('thickness_profile', message, strokes)
    for name in NEWER:
        if len(getattr(message, name, ())):
            check_lengths('thickness_profile', message, ('time', name))
    status, thickness = np.array(message.status, np.uint8), np.array(message.thickness)
    cause = _of_each_sample(message, 'cause', np.uint8, Cause.NONE)
    for name, values, last in ('status', status, max(Status)), ('cause', cause, max(Cause)):
        if (unknown := values[values > last]).size:
            raise ConversionError(f'thickness_profile: expected each {name} up to {last}, found '
                                  f'{unknown[0]}; is its sender of another version?')
    measured = thickness[status == Status.MEASURED]
    if (impossible := measured[~((measured > 0) & (measured < np.inf))]).size:
        raise ConversionError('thickness_profile: expected a thickness above 0 where it is '
                              f'measured, found {impossible[0]}; is its sender bpc?')
    return ThicknessProfile(
        stamp_ns=stamp_to_ns(message.header.stamp), print_id=message.print_id,
        print_start_ns=stamp_to_ns(message.print_start), capture=message.capture,
        method=message.method, time=np.array(message.time),
        arc_length=np.array(message.arc_length), points=points_of(message, ''),
        extruding=np.array(message.extruding, bool),
        extruder_known=_of_each_sample(message, 'extruder_known', bool, True),
        stroke=_of_each_sample(message, 'stroke', np.intp, 1), status=status,
        thickness=thickness, sigma=np.array(message.thickness_sigma),
        left=np.array(message.left), right=np.array(message.right),
        left_points=points_of(message, 'left_'), right_points=points_of(message, 'right_'),
        layer=_of_each_sample(message, 'layer', np.intp, 0),
        seen_in=_of_each_sample(message, 'seen_in', np.intp, message.capture),
        cause=cause, **{name: _of_each_sample(message, name, float, np.nan) for name in SIZES},
        shift=np.array(getattr(message, 'shift', (np.nan,) * 3), float),
        tip_height=getattr(message, 'tip_height', np.nan),
        processing_time=message.processing_time)


def change_from_message(message: ThicknessProfileUpdateMsg) -> ProfileChange:
    """Convert what changed in a profile. Raises ConversionError for impossible values."""
    part, index = profile_from_message(message.profile), np.array(message.index, np.intp)
    if len(index) != len(part) or (np.diff(index) <= 0).any():
        raise ConversionError('thickness_profile/update: expected an increasing place for each '
                              f'sample, found {len(index)} for {len(part)}; is its sender bpc?')
    return ProfileChange(stamp_to_ns(message.base), index, part)
