"""Poses of a moving frame over time, interpolated at a stamp."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
import math

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from bpc_perception.core.arrays import Array

# More than the flange of an LBR Med can do: its joints turn by 85 to 180 degrees/s at most.
MAXIMUM_SPEED_M_S = 5.0
MAXIMUM_TURN_RAD_S = 10.0
# How far a pose may be off because its stamp is.
JITTER_M = 1e-3
JITTER_RAD = 5e-3
CLOCK_SET_BACK_S = 1.0  # a pose that is earlier by more than this is of a clock that was set


def pose_matrix(position: Iterable[float], quaternion: Iterable[float]) -> Array:
    """Return the transform (4, 4) of a position (3,) [m] and a unit quaternion (4,) x, y, z, w.

    Raises ValueError if a number is not finite or the quaternion is not of unit length.
    """
    numbers = (*position, *quaternion)
    if not all(map(math.isfinite, numbers)):
        raise ValueError('pose: expected finite numbers, found '
                         f'{np.array(numbers[:3])} and {np.array(numbers[3:])}')
    length = math.hypot(*numbers[3:])
    if abs(length - 1) > 1e-2:
        raise ValueError(f'pose: expected a quaternion of length 1, found {length:.4g}')
    # Not with SciPy's Rotation: for a single rotation its checks take ten times as long, and a
    # robot sends a thousand poses a second.
    px, py, pz = numbers[:3]
    x, y, z, w = (number / length for number in numbers[3:])
    return np.array((
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), px),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), py),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), pz),
        (0.0, 0.0, 0.0, 1.0)))


class PoseBuffer:
    """The latest poses of a frame, in order of their stamps.

    A pose that the frame cannot have reached is refused. A jump that lasts is believed as soon as
    there was time enough to get there.
    """

    def __init__(self, length: int = 10000, maximum_speed: float = MAXIMUM_SPEED_M_S,
                 maximum_turn: float = MAXIMUM_TURN_RAD_S) -> None:
        """Keep so many poses; the frame is no faster than these [m/s], [rad/s]."""
        self._stamps: deque[int] = deque(maxlen=length)
        self._poses: deque[Array] = deque(maxlen=length)
        self._maximum_speed, self._maximum_turn = maximum_speed, maximum_turn

    def add(self, stamp_ns: int, T_target_source: Array) -> bool:
        """Add a pose (4, 4) [m]; return False, and add nothing, if it is late or a jump.

        A pose that is earlier than any network can have delayed it is of a clock that was set.
        Nobody can say which of the other poses are of the same clock, so they are forgotten.
        """
        if self._stamps:
            passed = (stamp_ns - self._stamps[-1]) * 1e-9
            if passed < -CLOCK_SET_BACK_S:
                self.clear()
            elif passed <= 0 or not self._reachable(T_target_source, passed):
                return False
        self._stamps.append(stamp_ns)
        self._poses.append(T_target_source)
        return True

    def _reachable(self, T_target_source: Array, passed: float) -> bool:
        """Return whether the frame can get from the last pose to this one in a time [s]."""
        last = self._poses[-1]
        distance = math.dist(last[:3, 3].tolist(), T_target_source[:3, 3].tolist())
        cosine = (float(np.vdot(last[:3, :3], T_target_source[:3, :3])) - 1) / 2
        turn = math.acos(min(max(cosine, -1.0), 1.0))
        return (distance <= self._maximum_speed * passed + JITTER_M
                and turn <= self._maximum_turn * passed + JITTER_RAD)

    def clear(self) -> None:
        """Forget all poses."""
        self._stamps.clear()
        self._poses.clear()

    def at(self, stamp_ns: int, maximum_gap: float) -> Array | None:
        """Return the pose (4, 4) [m] at a time, between the poses before and after it.

        Position is interpolated linearly, rotation spherical-linearly. None unless there are
        poses on both sides, no more than ``maximum_gap`` [s] apart, or one of exactly this time.
        """
        after = int(np.searchsorted(np.array(self._stamps), stamp_ns))
        if after == len(self._stamps):
            return None
        if self._stamps[after] == stamp_ns:
            return self._poses[after]
        if after == 0:
            return None
        before_ns, after_ns = self._stamps[after - 1], self._stamps[after]
        if after_ns - before_ns > maximum_gap * 1e9:
            return None
        share = (stamp_ns - before_ns) / (after_ns - before_ns)
        return _between(self._poses[after - 1], self._poses[after], share)


def _between(first: Array, second: Array, share: float) -> Array:
    """Return the pose (4, 4) at a share of the way from one pose (4, 4) to another."""
    pair = np.stack((first, second))
    pose = np.eye(4)
    pose[:3, :3] = Slerp((0, 1), Rotation.from_matrix(pair[:, :3, :3]))(share).as_matrix()
    pose[:3, 3] = (1 - share) * pair[0, :3, 3] + share * pair[1, :3, 3]
    return pose
