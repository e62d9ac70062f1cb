"""The nozzle tip in the flange frame, from poses with the tip in one spot (pivoting)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.geometry import transform

FEWEST_POSES = 3


@dataclass(frozen=True)
class Pivot:
    """What pivoting finds.

    Attributes:
        offset: (3,) nozzle tip in the flange frame [m].
        offset_sigma: (3,) its standard deviations [m].
        spot: (3,) where the tip stood in the base frame [m].
        residuals: (N,) distance from the spot at which each pose puts the tip [m].
    """

    offset: Array
    offset_sigma: Array
    spot: Array
    residuals: Array

    @property
    def rms(self) -> float:
        """Root mean square of the residuals [m]."""
        return float(np.sqrt(np.mean(self.residuals**2)))


def pivot(T_base_flange: Array, largest_sigma: float = 1e-3) -> Pivot:
    """Find the tip from flange poses (N, 4, 4) that all have it in one spot.

    Each pose gives three equations R t + p = c, linear in the tip t and the spot c. Raises
    CalibrationError with fewer than three poses, or where the flange was not turned about two
    axes far enough to know the tip to ``largest_sigma`` [m].
    """
    count = len(T_base_flange)
    if count < FEWEST_POSES:
        raise CalibrationError(f'pivoting: expected {FEWEST_POSES} poses or more, found {count}')
    R, p = T_base_flange[:, :3, :3], T_base_flange[:, :3, 3]
    A = np.concatenate((R, np.broadcast_to(-np.eye(3), R.shape)), axis=2).reshape(-1, 6)
    inverse = np.linalg.pinv(A.T @ A)
    if np.linalg.matrix_rank(A, tol=1e-3) < 6:
        raise CalibrationError('pivoting: expected poses turned about two axes, found the flange '
                               f'turned about {"one" if _turned(R) else "none"} only')
    solution = -inverse @ A.T @ p.ravel()
    residuals = A @ solution + p.ravel()
    variance = residuals @ residuals / (3 * count - 6)
    sigma = np.sqrt(variance * np.diag(inverse)[:3])
    if sigma.max() > largest_sigma:
        raise CalibrationError(
            f'pivoting: expected the tip to be known to {largest_sigma * 1e3:g} mm, found '
            f'{sigma.max() * 1e3:.2g} mm: turn the flange further, about two axes, and keep the '
            'tip in the spot')
    offset, spot = solution[:3], solution[3:]
    distances = np.linalg.norm(transform_each(T_base_flange, offset) - spot, axis=1)
    return Pivot(offset, sigma, spot, distances)


def transform_each(T: Array, point: Array) -> Array:
    """One point (3,) taken through each of the transforms (N, 4, 4)."""
    return np.stack([transform(each, point) for each in T])


def _turned(R: Array) -> bool:
    return bool(np.abs(R - R[0]).max() > 1e-3)


@dataclass(frozen=True)
class Rest:
    """A stretch of time in which the flange stood still.

    Attributes:
        start_ns, end_ns: when [ns].
        T_base_flange: (4, 4) where.
    """

    start_ns: int
    end_ns: int
    T_base_flange: Array


def rests(stamps_ns: NDArray[np.int64], T_base_flange: Array, duration: float = 1.0,
          distance: float = 2e-4, angle: float = 5e-4) -> list[Rest]:
    """The stretches of at least ``duration`` [s] in which poses (N, 4, 4) did not change.

    Not change: stay within ``distance`` [m] and ``angle`` [rad] of the first of the stretch. The
    pose in the middle stands for it. Stretches with the same pose, one after the other, are one.
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
    moved = float(np.linalg.norm(first[:3, 3] - second[:3, 3]))
    # The chord of a small rotation: Frobenius norm = 2 sqrt(2) sin(angle / 2).
    turned = float(np.linalg.norm(first[:3, :3] - second[:3, :3])) / np.sqrt(2)
    return moved <= distance and turned <= angle
