"""Convert deposition paths from and to messages."""

from __future__ import annotations

from struct import unpack_from

from geometry_msgs.msg import Point, Pose, PoseStamped
from nav_msgs.msg import Path
import numpy as np
from std_msgs.msg import Header

from bpc_interfaces.msg import DepositionPath as DepositionPathMsg
from bpc_perception.core.arrays import Flags
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.messages.array_fields import (
    axes_fields,
    check_lengths,
    floats_field,
    points_of,
)
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp, stamp_to_ns

MOST_NAV_POSES = 2000  # in a path for viewers


def path_to_message(path: DepositionPath, frame_id: str) -> DepositionPathMsg:
    """Convert a path in the robot base frame, named ``frame_id``, to a message."""
    return DepositionPathMsg(
        header=Header(stamp=ns_to_stamp(path.start_ns), frame_id=frame_id),
        print_id=path.print_id, complete_until=path.complete_until, finished=path.finished,
        time=floats_field(path.time), arc_length=floats_field(path.arc_length),
        **axes_fields('', path.points), plunger_velocity=floats_field(path.plunger_velocity),
        flow_rate=floats_field(path.flow_rate), extruding=path.extruding.tolist(),
        extruder_known=path.extruder_known.tolist())


def print_id_in(data: bytes) -> str:
    """Return the print_id of a serialized DepositionPath, without unpacking all of the path.

    [OMG DDS-XTypes 1.3, plain CDR: a head of 4 bytes, from which numbers are aligned; a string is
    its length and its bytes with a NUL]
    """
    number = '<I' if data[1] & 1 else '>I'
    place = 4 + 8  # behind the stamp
    frame_length, = unpack_from(number, data, place)
    place += 4 + frame_length
    place += -place % 4
    length, = unpack_from(number, data, place)
    return data[place + 4:place + 4 + length - 1].decode(errors='replace')


def path_from_message(message: DepositionPathMsg) -> DepositionPath:
    """Convert a path from its message. Raises ConversionError for impossible values."""
    names = ('time', 'arc_length', 'x', 'y', 'z', 'plunger_velocity', 'flow_rate', 'extruding')
    check_lengths('deposition_path', message, names)
    time, arc_length = np.array(message.time), np.array(message.arc_length)
    points = points_of(message, '')
    if not (np.isfinite(points).all() and np.isfinite(time).all() and (np.diff(time) > 0).all()
            and np.isfinite(arc_length).all() and (np.diff(arc_length) >= 0).all()):
        raise ConversionError('deposition_path: expected finite points, and times and arc lengths '
                              'that increase, found others; is its sender bpc?')
    return DepositionPath(
        print_id=message.print_id, start_ns=stamp_to_ns(message.header.stamp),
        complete_until=message.complete_until, finished=bool(message.finished), time=time,
        arc_length=arc_length, points=points,
        plunger_velocity=np.array(message.plunger_velocity),
        flow_rate=np.array(message.flow_rate), extruding=np.array(message.extruding, bool),
        extruder_known=_extruder_known(message))


def _extruder_known(message: DepositionPathMsg) -> Flags:
    """Return where (N,) the extruder's state is known; older recordings do not say it."""
    said = getattr(message, 'extruder_known', ())
    if len(said):
        check_lengths('deposition_path', message, ('time', 'extruder_known'))
        return np.array(said, bool)
    rates = np.array((message.plunger_velocity, message.flow_rate))
    known = np.isfinite(rates).any(axis=0) | np.array(message.extruding, bool)
    # An extruder that tells no rate is on or off, all along.
    return known if np.isfinite(rates).any() else np.ones(len(message.time), bool)


def path_to_nav(path: DepositionPath, frame_id: str) -> Path:
    """Convert a path for RViz and Foxglove: positions with their times, without orientations.

    A long path is thinned to every n-th point and the last, because poses are slow in Python.
    """
    shown = np.arange(len(path) - 1, -1, -(len(path) // MOST_NAV_POSES + 1))[::-1]
    poses = []
    for time, (x, y, z) in zip(path.time[shown].tolist(), path.points[shown].tolist(),
                               strict=True):
        stamp = ns_to_stamp(path.start_ns + round(time * 1e9))
        poses.append(PoseStamped(header=Header(stamp=stamp, frame_id=frame_id),
                                 pose=Pose(position=Point(x=x, y=y, z=z))))
    return Path(header=Header(stamp=ns_to_stamp(path.start_ns), frame_id=frame_id), poses=poses)
