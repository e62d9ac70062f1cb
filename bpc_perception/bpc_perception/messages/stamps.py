"""Stamps and frames of messages, and the error of what cannot be converted faithfully."""

from __future__ import annotations

from typing import Any

from builtin_interfaces.msg import Time


class ConversionError(ValueError):
    """A message is not what was expected; the text names both."""


def stamp_to_ns(stamp: Time) -> int:
    """Nanoseconds of a message's stamp."""
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def ns_to_stamp(stamp_ns: int) -> Time:
    """The message's form of a stamp [ns]."""
    return Time(sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)


def check_frame(name: str, message: Any, frame_id: str) -> None:
    """Raise ConversionError where a message is in another frame; an empty name is no other."""
    if message.header.frame_id not in ('', frame_id):
        raise ConversionError(f'{name}: expected frame {frame_id}, '
                              f'found {message.header.frame_id}')
