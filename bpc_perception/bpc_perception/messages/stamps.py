"""Convert stamps, check frames; and the error for what cannot be converted faithfully."""

from __future__ import annotations

from struct import unpack_from
from typing import Any

from builtin_interfaces.msg import Time


class ConversionError(ValueError):
    """A message is not what was expected; the text names both."""


def stamp_to_ns(stamp: Time) -> int:
    """Convert the stamp of a message to nanoseconds."""
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def ns_to_stamp(stamp_ns: int) -> Time:
    """Convert nanoseconds to the stamp of a message."""
    return Time(sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)


def stamp_in(data: bytes) -> int:
    """Return the stamp [ns] of a serialized message that begins with a header.

    [OMG DDS-XTypes 1.3, plain CDR: a head of 4 bytes, from which numbers are aligned]
    """
    seconds, nanoseconds = unpack_from('<iI' if data[1] & 1 else '>iI', data, 4)
    return int(seconds) * 10**9 + int(nanoseconds)


def check_frame(name: str, message: Any, frame_id: str) -> None:
    """Raise ConversionError when a message names another frame than ``frame_id``."""
    found = message.header.frame_id
    if found not in ('', frame_id):
        raise ConversionError(f'{name}: expected frame {frame_id}, found {found}; set base_frame '
                              f'of path_recorder and thickness to {found}, or publish in '
                              f'{frame_id}')
