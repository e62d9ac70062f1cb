"""Whether a calibration still holds: how far beside the path the bead is seen.

A camera whose pose in the base frame is off by a shift sees every bead off by it, to the left of
the path in one direction of travel and to its right in the other. So a shift can be told from a
bead that always lies to one side, if the path goes in different directions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.profile import Status, ThicknessProfile

FEWEST_SAMPLES = 30
BLOCK = 5e-3  # along the path, within which deviations go together [m]
FEWEST_BLOCKS = 6
WEAKEST = 0.1  # share of the path that has to go another way than the rest
LARGEST_SIGMA = 0.2e-3  # of the shift in its poorest direction [m]


@dataclass(frozen=True)
class Offset:
    """Where the bead is seen, relative to the path.

    Attributes:
        shift: (3,) of the camera in the base frame, along the bed [m]; to be taken from its
            position. An error of the nozzle's offset looks the same while the flange keeps its
            orientation.
        sigma: standard deviation of the shift, in its poorest direction [m].
        side: how far to the left of the direction of travel the bead lies besides [m].
        scatter: root mean square of what is left [m].
        samples: number of samples it comes from.
    """

    shift: Array
    sigma: float
    side: float
    scatter: float
    samples: int

    @property
    def size(self) -> float:
        """Length of the shift [m]."""
        return float(np.linalg.norm(self.shift))

    def holds(self, tolerance: float) -> bool | None:
        """Whether the shift is within a tolerance [m]; None where that cannot be told."""
        if self.size + 2 * self.sigma <= tolerance:
            return True
        return False if self.size - 2 * self.sigma > tolerance else None


def offset(profiles: Sequence[ThicknessProfile]) -> Offset:
    """Find the shift from profiles of prints.

    Raises CalibrationError where too little was measured, or in one direction only.
    """
    points = np.concatenate([each.points[_measured(each)] for each in profiles])
    left = np.concatenate([each.left_points[_measured(each)] for each in profiles])
    right = np.concatenate([each.right_points[_measured(each)] for each in profiles])
    blocks = np.concatenate([1000 * index + each.arc_length[_measured(each)] // BLOCK
                             for index, each in enumerate(profiles)])
    if len(points) < FEWEST_SAMPLES or len(np.unique(blocks)) < FEWEST_BLOCKS:
        raise CalibrationError(
            f'check: expected {FEWEST_SAMPLES} measured samples on '
            f'{FEWEST_BLOCKS * BLOCK * 1e3:g} mm of path or more, found {len(points)}')
    across = left - right
    across /= np.linalg.norm(across, axis=1)[:, None]
    beside = np.sum(((left + right) / 2 - points) * across, axis=1)
    _, _, axes = np.linalg.svd(across, full_matrices=False)
    e1, e2 = axes[:2]
    model = np.column_stack((across @ e1, across @ e2, np.ones(len(points))))
    inverse = np.linalg.pinv(model.T @ model)
    solution = inverse @ model.T @ beside
    rest = beside - model @ solution
    covariance = _clustered(model, rest, blocks, inverse)
    sigma = float(np.sqrt(np.linalg.eigvalsh(covariance[:2, :2])[-1]))
    # Of a straight line e1, the only direction across, and the side are one and the same.
    weakest = np.linalg.svd(model, compute_uv=False)[-1] / np.sqrt(len(points))
    if weakest < WEAKEST or sigma > LARGEST_SIGMA:
        raise CalibrationError('check: expected a print that goes in several directions, so that '
                               'a shift of the camera can be told from a bead that lies to one '
                               'side, found one that does not')
    return Offset(
        shift=solution[0] * e1 + solution[1] * e2, sigma=sigma, side=float(solution[2]),
        scatter=float(np.sqrt(np.mean(rest**2))), samples=len(points))


def _measured(profile: ThicknessProfile) -> Array:
    measured: Array = ((profile.status == Status.MEASURED)
                       & np.isfinite(profile.left_points).all(axis=1)
                       & np.isfinite(profile.right_points).all(axis=1))
    return measured


def _clustered(model: Array, rest: Array, blocks: Array, inverse: Array) -> Array:
    """Covariance of a least-squares solution whose errors go together within blocks.

    [Liang and Zeger 1986, the sandwich estimator; scaled for few blocks as Stata does]
    """
    names, index = np.unique(blocks, return_inverse=True)
    scores = np.zeros((len(names), model.shape[1]))
    np.add.at(scores, index, model * rest[:, None])
    count, size = len(names), len(rest)
    scale = count / (count - 1) * (size - 1) / (size - model.shape[1])
    covariance: Array = scale * inverse @ scores.T @ scores @ inverse
    return covariance
