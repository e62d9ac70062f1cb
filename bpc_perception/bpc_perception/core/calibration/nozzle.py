"""The nozzle tip in the flange frame, from poses with the tip in one spot (pivoting)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.geometry import transform

FEWEST_POSES = 3
RANK_TOLERANCE = 1e-3  # singular values below it count as 0
ROTATION_TOLERANCE = 1e-3  # of an element of a matrix, within which rotations are the same


@dataclass(frozen=True)
class Pivot:
    """What pivoting finds.

    Attributes:
        offset: (3,) nozzle tip in the flange frame [m].
        offset_sigma: (3,) its standard deviations [m].
        spot: (3,) where the tip stood in the base frame [m].
        residuals: (N,) distance from the spot to the tip by each pose [m].
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
    """Find the tip from flange poses (N, 4, 4) [m] that all have it in one spot.

    Each pose gives three equations R t + p = c, linear in the tip t and the spot c.

    Raises CalibrationError with fewer than three poses, or if the flange was not turned about two
    axes far enough to know the tip to ``largest_sigma`` [m].
    """
    count = len(T_base_flange)
    if count < FEWEST_POSES:
        raise CalibrationError(f'pivoting: expected {FEWEST_POSES} poses or more, found {count}'
                               '; pivot about the tip and stand still in each')
    R, p = T_base_flange[:, :3, :3], T_base_flange[:, :3, 3]
    A = np.concatenate((R, np.broadcast_to(-np.eye(3), R.shape)), axis=2).reshape(-1, 6)
    inverse = np.linalg.pinv(A.T @ A)
    if np.linalg.matrix_rank(A, tol=RANK_TOLERANCE) < 6:
        raise CalibrationError('pivoting: expected poses turned about two axes, found the flange '
                               f'turned about {"one" if _turned(R) else "none"} only'
                               '; turn it about another, too')
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
    tips = np.stack([transform(each, offset) for each in T_base_flange])
    return Pivot(offset, sigma, spot, np.linalg.norm(tips - spot, axis=1))


def _turned(R: Array) -> bool:
    """Return whether rotations (N, 3, 3) differ."""
    return bool(np.abs(R - R[0]).max() > ROTATION_TOLERANCE)
