"""Read messages that were recorded with another version of their type.

The definition that lies in the recording says which fields its messages have.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from functools import cache
import math
from typing import Any

from geometry_msgs.msg import PoseStamped
import numpy as np
from rclpy.serialization import deserialize_message

from bpc_perception.messages.poses.stamped_pose import stamped_pose_in
from bpc_perception.messages.types import message_definition, message_type, MessageTypeError
from bpc_perception.recording.storage.raw_message import Channel

Reader = Callable[[bytes], Any]


@cache
def reader_of(channel: Channel, light: bool = False) -> Reader:
    """Return what makes messages of the bytes of a channel; light ones cannot be published.

    Where the installed type has further fields, they are what the type says, numbers of floating
    point NaN; where the recorded one has, they are left out.

    Raises MessageTypeError when the type is not installed, or its versions contradict each other.
    """
    kind, definition = channel.type_name, channel.definition.decode(errors='replace')
    installed, own_definition = message_type(kind), message_definition(kind)
    if (channel.definition_encoding != 'ros2msg' or not definition
            or _bare(definition) == _bare(own_definition)):
        return _read_pose if light and installed is PoseStamped else _reader(installed)
    # Imported late: seldom needed.
    from rosbags.typesys import get_types_from_msg, get_typestore, Stores

    try:
        recorded = get_types_from_msg(definition, kind)
    except Exception:  # whatever the parser raises on what is no definition
        return _reader(installed)
    own = get_types_from_msg(own_definition, kind)
    if recorded == own:
        return _reader(installed)
    _expect_no_contradiction(kind, recorded, own)
    store = get_typestore(Stores.EMPTY)
    store.register(recorded)
    return lambda data: _filled(installed(), store.deserialize_cdr(data, kind))


def _reader(installed: Any) -> Reader:
    return lambda data: deserialize_message(data, installed)


def _read_pose(data: bytes) -> Any:
    """Return a stamped pose; rclpy says whether what is out of the ordinary is damaged."""
    return stamped_pose_in(data) or deserialize_message(data, PoseStamped)


def _bare(definition: str) -> list[list[str]]:
    """Return the words of a definition without comments and empty lines."""
    lines = (line.split('#')[0].split() for line in definition.splitlines())
    return [words for words in lines if words]


def _expect_no_contradiction(kind: str, recorded: Mapping[str, Any],
                             own: Mapping[str, Any]) -> None:
    """Raise MessageTypeError unless one version only adds to the other."""
    more, less = [], []
    for name in recorded.keys() & own.keys():
        for then, now in ((recorded[name][0], own[name][0]), (recorded[name][1], own[name][1])):
            before = {entry[0]: entry[1:] for entry in then}  # constants, then fields
            after = {entry[0]: entry[1:] for entry in now}
            more += sorted(after.keys() - before.keys())
            less += sorted(before.keys() - after.keys())
            changed = [entry for entry in before.keys() & after.keys()
                       if before[entry] != after[entry]]
            more += changed
            less += changed
    if more and less:
        raise MessageTypeError(
            f'message type: expected recordings of the installed version of {kind}, found one '
            f'whose definition has {", ".join(less)} instead of {", ".join(more)}; read it with '
            'the version of bpc or of the driver that recorded it')


def _filled(message: Any, recorded: Any) -> Any:
    """Return a message with the fields that were recorded."""
    for name, kind in message.get_fields_and_field_types().items():
        if hasattr(recorded, name):
            setattr(message, name, _value(getattr(message, name), getattr(recorded, name), kind))
        elif kind in ('double', 'float'):
            setattr(message, name, math.nan)
    return message


def _value(default: Any, recorded: Any, kind: str) -> Any:
    """Return the value of a field, as the installed type has it."""
    if hasattr(default, 'get_fields_and_field_types'):
        return _filled(default, recorded)
    if isinstance(default, array):
        return array(default.typecode, recorded.tobytes())
    if isinstance(recorded, list) and recorded and is_dataclass(recorded[0]):
        one = message_type(kind.split('[')[0].removeprefix('sequence<').split(',')[0]
                           .rstrip('>').replace('/', '/msg/'))
        return [_filled(one(), each) for each in recorded]
    if isinstance(recorded, np.ndarray) and isinstance(default, list):
        return recorded.tolist()
    return recorded
