"""Poses of a moving frame over time, interpolated at a stamp."""

from __future__ import annotations

from collections import deque
import math

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from bpc_perception.core.arrays import Array

# More than the flange of an LBR Med reaches: its joints turn by 85 to 180 degrees/s at most.
MAXIMUM_SPEED, MAXIMUM_TURN = 5.0, 10.0  # [m/s], [rad/s]
JITTER, JITTER_TURN = 1e-3, 5e-3  # by which a pose may be off where stamps are [m], [rad]
SET_BACK = 1.0  # by which a pose is earlier only where a clock was set [s]


def pose_matrix(position: Array, quaternion: Array) -> Array:
    """The 4x4 transform of a position (3,) [m] and a unit quaternion (4,) as x, y, z, w.

    Raises ValueError where a number is not finite or the quaternion is not of unit length.
    """
    numbers = (*position.tolist(), *quaternion.tolist())
    if not all(map(math.isfinite, numbers)):
        raise ValueError(f'pose: expected finite numbers, found {position} and {quaternion}')
    length = math.hypot(*numbers[3:])
    if abs(length - 1) > 1e-2:
        raise ValueError(f'pose: expected a quaternion of length 1, found {length:.4g}')
    # Not by SciPy's Rotation: for a single one its checks take ten times as long, and a robot
    # sends a thousand a second.
    px, py, pz = numbers[:3]
    x, y, z, w = (number / length for number in numbers[3:])
    return np.array((
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), px),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), py),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), pz),
        (0.0, 0.0, 0.0, 1.0)))


class PoseBuffer:
    """The latest poses of a frame, in order of their stamps.

    What the frame cannot have come to is refused; what lasts is believed as soon as there was
    time enough to get there.
    """

    def __init__(self, length: int = 10000, maximum_speed: float = MAXIMUM_SPEED,
                 maximum_turn: float = MAXIMUM_TURN) -> None:
        self._stamps: deque[int] = deque(maxlen=length)
        self._poses: deque[Array] = deque(maxlen=length)
        self._maximum_speed, self._maximum_turn = maximum_speed, maximum_turn

    def add(self, stamp_ns: int, T_target_source: Array) -> bool:
        """Append a pose (4, 4); False, and nothing kept, if it is late, or a jump.

        One so much earlier that no network can have held it up is of a clock that was set. Which
        of the others are of the same clock nobody can say then: they are forgotten.
        """
        if self._stamps:
            passed = (stamp_ns - self._stamps[-1]) * 1e-9
            if passed < -SET_BACK:
                self.clear()
            elif passed <= 0 or not self._reachable(T_target_source, passed):
                return False
        self._stamps.append(stamp_ns)
        self._poses.append(T_target_source)
        return True

    def _reachable(self, T_target_source: Array, passed: float) -> bool:
        last = self._poses[-1]
        distance = math.dist(last[:3, 3].tolist(), T_target_source[:3, 3].tolist())
        cosine = (float(np.vdot(last[:3, :3], T_target_source[:3, :3])) - 1) / 2
        turn = math.acos(min(max(cosine, -1.0), 1.0))
        return (distance <= self._maximum_speed * passed + JITTER
                and turn <= self._maximum_turn * passed + JITTER_TURN)

    def clear(self) -> None:
        """Forget all poses."""
        self._stamps.clear()
        self._poses.clear()

    @property
    def latest_ns(self) -> int | None:
        """Stamp of the last pose, or None."""
        return self._stamps[-1] if self._stamps else None

    def at(self, stamp_ns: int, maximum_gap: float) -> Array | None:
        """The pose (4, 4) at a time, between the poses before and after it.

        Position is linear, rotation spherical-linear. None where there is no pose on either
        side or the two are more than ``maximum_gap`` seconds apart.
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
        pair = np.stack((self._poses[after - 1], self._poses[after]))
        pose = np.eye(4)
        pose[:3, :3] = Slerp((0, 1), Rotation.from_matrix(pair[:, :3, :3]))(share).as_matrix()
        pose[:3, 3] = (1 - share) * pair[0, :3, 3] + share * pair[1, :3, 3]
        return pose
