"""Read stamped poses from their bytes, since a robot sends up to a thousand a second.

rclpy makes each of the objects that a message consists of by a constructor in Python, which takes
ten times as long.
"""

from __future__ import annotations

from struct import error, Struct
from typing import NamedTuple

HEAD = b'\0\1\0\0'  # plain CDR, numbers begin with their last byte
HEADER, NUMBERS = Struct('<iII'), Struct('<7d')


class Stamp(NamedTuple):
    """Fields of a builtin_interfaces/Time."""

    sec: int
    nanosec: int


class Header(NamedTuple):
    """Fields of a std_msgs/Header."""

    stamp: Stamp
    frame_id: str


class Point(NamedTuple):
    """Fields of a geometry_msgs/Point."""

    x: float
    y: float
    z: float


class Quaternion(NamedTuple):
    """Fields of a geometry_msgs/Quaternion."""

    x: float
    y: float
    z: float
    w: float


class Pose(NamedTuple):
    """Fields of a geometry_msgs/Pose."""

    position: Point
    orientation: Quaternion


class StampedPose(NamedTuple):
    """Fields of a geometry_msgs/PoseStamped."""

    header: Header
    pose: Pose


def stamped_pose_in(data: bytes) -> StampedPose | None:
    """Return the fields of a serialized PoseStamped; None = it is damaged, or out of the ordinary.

    [OMG DDS-XTypes 1.3, plain CDR: a head of 4 bytes, from which numbers are aligned; a string is
    its length and its bytes with a NUL]
    """
    try:
        seconds, nanoseconds, length = HEADER.unpack_from(data, len(HEAD))
        begin = len(HEAD) + HEADER.size
        end = begin + length
        place = end + (len(HEAD) - end) % 8
        x, y, z, *quaternion = NUMBERS.unpack_from(data, place)
        frame_id = data[begin:end - 1].decode()
    except (error, UnicodeDecodeError):
        return None
    if (not data.startswith(HEAD) or data.find(b'\0', begin) != end - 1
            or len(data) != place + NUMBERS.size):
        return None
    return StampedPose(Header(Stamp(seconds, nanoseconds), frame_id),
                       Pose(Point(x, y, z), Quaternion(*quaternion)))
