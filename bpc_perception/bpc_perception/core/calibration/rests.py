"""When and where the flange stood still."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array


@dataclass(frozen=True)
class Rest:
    """A stretch of time in which the flange stood still.

    Attributes:
        start_ns, end_ns: when [ns].
        T_base_flange: (4, 4) where [m].
    """

    start_ns: int
    end_ns: int
    T_base_flange: Array


def rests(stamps_ns: NDArray[np.int64], T_base_flange: Array, duration: float = 1.0,
          distance: float = 2e-4, angle: float = 5e-4) -> list[Rest]:
    """Return the stretches of time in which the flange stood still.

    Each pose of a stretch is within ``distance`` and ``angle`` of its first. The pose in the
    middle stands for the stretch. Of successive stretches with the same pose the first counts.

    Args:
        stamps_ns: (N,) of the poses [ns], increasing.
        T_base_flange: (N, 4, 4) poses [m].
        duration: of a stretch, at least [s].
        distance: by which a standing flange may seem to move [m].
        angle: by which it may seem to turn [rad].
    """
    found: list[Rest] = []
    start = 0
    for index in range(1, len(stamps_ns) + 1):
        if index < len(stamps_ns) and _same(T_base_flange[start], T_base_flange[index],
                                            distance, angle):
            continue
        if stamps_ns[index - 1] - stamps_ns[start] >= duration * 1e9:
            middle = T_base_flange[(start + index - 1) // 2]
            if not (found and _same(found[-1].T_base_flange, middle, 2 * distance, 2 * angle)):
                found.append(Rest(int(stamps_ns[start]), int(stamps_ns[index - 1]), middle))
        start = index
    return found


def _same(first: Array, second: Array, distance: float, angle: float) -> bool:
    """Return whether two poses (4, 4) are within a distance [m] and an angle [rad]."""
    moved = float(np.linalg.norm(first[:3, 3] - second[:3, 3]))
    # The chord of a small rotation: Frobenius norm = 2 sqrt(2) sin(angle / 2).
    turned = float(np.linalg.norm(first[:3, :3] - second[:3, :3])) / np.sqrt(2)
    return moved <= distance and turned <= angle
