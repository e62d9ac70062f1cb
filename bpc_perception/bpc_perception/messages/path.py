"""Deposition paths from and to messages."""

from __future__ import annotations

from geometry_msgs.msg import Point, Pose, PoseStamped
from nav_msgs.msg import Path
import numpy as np
from std_msgs.msg import Header

from bpc_interfaces.msg import (
    DepositionPath as DepositionPathMsg,
)
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.messages.array_fields import (
    axes_fields,
    check_lengths,
    floats_field,
    points_of,
)
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp, stamp_to_ns

NAV_POSES = 2000  # at most in a path to look at


def path_to_message(path: DepositionPath, frame_id: str) -> DepositionPathMsg:
    """A path in the robot base frame as a message."""
    return DepositionPathMsg(
        header=Header(stamp=ns_to_stamp(path.start_ns), frame_id=frame_id),
        print_id=path.print_id, complete_until=path.complete_until, finished=path.finished,
        time=floats_field(path.time), arc_length=floats_field(path.arc_length),
        **axes_fields('', path.points), plunger_velocity=floats_field(path.plunger_velocity),
        flow_rate=floats_field(path.flow_rate), extruding=path.extruding.tolist())


def path_from_message(message: DepositionPathMsg) -> DepositionPath:
    """A path from its message."""
    names = ('time', 'arc_length', 'x', 'y', 'z', 'plunger_velocity', 'flow_rate', 'extruding')
    check_lengths('deposition_path', message, names)
    time, arc_length = np.array(message.time), np.array(message.arc_length)
    points = points_of(message, '')
    if not (np.isfinite(points).all() and np.isfinite(time).all() and (np.diff(time) > 0).all()
            and np.isfinite(arc_length).all() and (np.diff(arc_length) >= 0).all()):
        raise ConversionError('deposition_path: expected finite points, and times and arc lengths '
                              'that increase, found others')
    return DepositionPath(
        print_id=message.print_id, start_ns=stamp_to_ns(message.header.stamp),
        complete_until=message.complete_until, finished=bool(message.finished), time=time,
        arc_length=arc_length, points=points,
        plunger_velocity=np.array(message.plunger_velocity),
        flow_rate=np.array(message.flow_rate), extruding=np.array(message.extruding, bool))


def path_to_nav(path: DepositionPath, frame_id: str) -> Path:
    """A path for RViz and Foxglove: positions, each with its time; orientation is not known.

    Of a long path only every n-th point, and the last: a pose is a slow thing in Python.
    """
    shown = np.arange(len(path) - 1, -1, -(len(path) // NAV_POSES + 1))[::-1]
    poses = []
    for time, (x, y, z) in zip(path.time[shown].tolist(), path.points[shown].tolist(),
                               strict=True):
        stamp = ns_to_stamp(path.start_ns + round(time * 1e9))
        poses.append(PoseStamped(header=Header(stamp=stamp, frame_id=frame_id),
                                 pose=Pose(position=Point(x=x, y=y, z=z))))
    return Path(header=Header(stamp=ns_to_stamp(path.start_ns), frame_id=frame_id), poses=poses)
