"""Put arrays into the fields of messages, large ones without a copy, and take them out."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image

from bpc_perception.core.arrays import Array
from bpc_perception.messages.stamps import ConversionError


def set_data(message: Any, values: NDArray[Any]) -> None:
    """Make ``message.data`` the bytes of a C-contiguous array, which must not change afterwards.

    The generated setter copies the bytes, or checks them one by one. Serialization takes any
    buffer from the private field of the property. Should that change, the bytes are copied.
    """
    _setter()(message, values.reshape(-1).view(np.uint8).data)


@cache
def _setter() -> Callable[[Any, memoryview], None]:
    """Return the fastest way that gives the right bytes for a small sample."""
    sample = np.arange(10, dtype=np.uint8)
    wanted, tried = Image(), Image()
    _copied(wanted, sample.data)
    with suppress(Exception):  # whatever another version raises for a field of another type
        _shared(tried, sample.data)
        if bytes(serialize_message(tried)) == bytes(serialize_message(wanted)):
            return _shared
    return _copied


def _shared(message: Any, data: memoryview) -> None:
    message._data = data  # keeps the array alive


def _copied(message: Any, data: memoryview) -> None:
    copy = array('B')
    copy.frombytes(data)
    message.data = copy


def floats_field(values: Array) -> array[float]:
    """Return values (N,) in the type that a field float64[] takes fastest."""
    return array('d', values.astype(np.float64).tobytes())


def axes_fields(prefix: str, points: Array) -> dict[str, array[float]]:
    """Return points (N, 3) as the three fields x, y, z with a prefix."""
    return {prefix + axis: floats_field(points[:, index]) for index, axis in enumerate('xyz')}


def points_of(message: Any, prefix: str) -> Array:
    """Return the points (N, 3) of the three fields x, y, z with a prefix."""
    return np.column_stack([np.array(getattr(message, prefix + axis)) for axis in 'xyz'])


def check_lengths(name: str, message: Any, fields: Sequence[str]) -> None:
    """Raise ConversionError unless the arrays of these fields have one length."""
    lengths = {field: len(getattr(message, field)) for field in fields}
    if len(set(lengths.values())) > 1:
        raise ConversionError(f'{name}: expected arrays of one length, found {lengths}'
                              '; look at what publishes it')
