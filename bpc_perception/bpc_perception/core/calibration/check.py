"""Whether a calibration still holds: how far beside the path the bead is seen.

If the camera's pose in the base frame is off by a shift, every bead is seen off by that shift: to
the left of the path in one direction of travel and to its right in the other. So if the path goes
in different directions, a shift can be told from a bead that always lies to one side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.profile import Status, ThicknessProfile

FEWEST_SAMPLES = 30
BLOCK_LENGTH_M = 5e-3  # of path, within which deviations are correlated
BLOCKS_PER_PROFILE = 1000  # numbers of a profile's blocks begin at a multiple; 5 m of path
FEWEST_BLOCKS = 6
LEAST_TURNING = 0.1  # share of the path that has to go another way than the rest
LARGEST_SIGMA_M = 0.2e-3  # of the shift in its poorest direction
ROUGH_SIGMA_M = 0.3e-3  # of a shift as it is seen at once


@dataclass(frozen=True)
class Offset:
    """Where the bead is seen, relative to the path.

    Attributes:
        shift: (3,) of the camera in the base frame, along the bed [m]; to be subtracted from its
            position. An error of the nozzle offset looks the same while the flange keeps its
            orientation.
        sigma: standard deviation of the shift, in its poorest direction [m].
        side: how far the bead lies to the left of the direction of travel, besides the shift [m].
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
        """Return whether the shift is within a tolerance [m]; None = not known well enough."""
        if self.size + 2 * self.sigma <= tolerance:
            return True
        return False if self.size - 2 * self.sigma > tolerance else None


@dataclass(frozen=True)
class _Beads:
    """Measured samples of prints.

    Attributes:
        points: (N, 3) of the path [m].
        left, right: (N, 3) side points [m].
        block: (N,) number of the block in which each lies.
    """

    points: Array
    left: Array
    right: Array
    block: Array


@dataclass(frozen=True)
class _Fit:
    """A least-squares solution (K,), its covariance (K, K), and what is left (N,)."""

    solution: Array
    covariance: Array
    rest: Array


def offset(profiles: Sequence[ThicknessProfile]) -> Offset:
    """Find the shift from profiles of prints.

    Raises CalibrationError if too little was measured, or in one direction only.
    """
    beads = _beads_of(profiles)
    count = len(beads.points)
    if count < FEWEST_SAMPLES or len(np.unique(beads.block)) < FEWEST_BLOCKS:
        raise CalibrationError(
            f'check: expected {FEWEST_SAMPLES} measured samples on '
            f'{FEWEST_BLOCKS * BLOCK_LENGTH_M * 1e3:g} mm of path or more, found {count}'
            '; take a longer print')
    across = beads.left - beads.right
    across /= np.linalg.norm(across, axis=1)[:, None]
    beside = np.sum(((beads.left + beads.right) / 2 - beads.points) * across, axis=1)
    _, _, axes = np.linalg.svd(across, full_matrices=False)
    e1, e2 = axes[:2]
    model = np.column_stack((across @ e1, across @ e2, np.ones(count)))
    fit = _fit(model, beside, beads.block)
    sigma = float(np.sqrt(np.linalg.eigvalsh(fit.covariance[:2, :2])[-1]))
    # For a straight line e1, the only direction across, and the side are one and the same.
    turning = np.linalg.svd(model, compute_uv=False)[-1] / np.sqrt(count)
    if turning < LEAST_TURNING or sigma > LARGEST_SIGMA_M:
        raise CalibrationError('check: expected a print that goes in several directions, so that '
                               'a shift of the camera can be told from a bead that lies to one '
                               'side, found one that does not'
                               '; take one with a curve or with crossing lines')
    return Offset(
        shift=fit.solution[0] * e1 + fit.solution[1] * e2, sigma=sigma,
        side=float(fit.solution[2]), scatter=float(np.sqrt(np.mean(fit.rest**2))), samples=count)


def rough_offset(shift: Array) -> Offset:
    """Return a shift (3,) that is seen at once, and no better [m]."""
    return Offset(shift, ROUGH_SIGMA_M, side=np.nan, scatter=np.nan, samples=0)


def rough_shift(profiles: Sequence[ThicknessProfile]) -> Array:
    """Return how far the ink seems to lie from the path (3,), as far as it is seen at once [m].

    0 where nothing looks as if it did.
    """
    shifts = [profile.shift for profile in profiles if np.isfinite(profile.shift).all()]
    return np.asarray(np.median(shifts, axis=0)) if shifts else np.zeros(3)


def _beads_of(profiles: Sequence[ThicknessProfile]) -> _Beads:
    shown = [(profile, _measured(profile)) for profile in profiles]
    return _Beads(
        points=np.concatenate([profile.points[kept] for profile, kept in shown]),
        left=np.concatenate([profile.left_points[kept] for profile, kept in shown]),
        right=np.concatenate([profile.right_points[kept] for profile, kept in shown]),
        block=np.concatenate([
            BLOCKS_PER_PROFILE * number + profile.arc_length[kept] // BLOCK_LENGTH_M
            for number, (profile, kept) in enumerate(shown)]))


def _measured(profile: ThicknessProfile) -> Flags:
    measured: Flags = ((profile.status == Status.MEASURED)
                       & np.isfinite(profile.left_points).all(axis=1)
                       & np.isfinite(profile.right_points).all(axis=1))
    return measured


def _fit(model: Array, values: Array, block: Array) -> _Fit:
    """Fit model (N, K) to values (N,) with least squares; errors are correlated within blocks.

    [Liang and Zeger 1986, the sandwich estimator; scaled for few blocks as Stata does]
    """
    inverse = np.linalg.pinv(model.T @ model)
    solution = inverse @ model.T @ values
    rest = values - model @ solution
    names, index = np.unique(block, return_inverse=True)
    scores = np.zeros((len(names), model.shape[1]))
    np.add.at(scores, index, model * rest[:, None])
    count, size = len(names), len(rest)
    scale = count / (count - 1) * (size - 1) / (size - model.shape[1])
    return _Fit(solution, scale * inverse @ scores.T @ scores @ inverse, rest)
