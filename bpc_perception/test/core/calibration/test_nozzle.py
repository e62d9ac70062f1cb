"""The nozzle offset from poses with the tip in one spot, placed by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.calibration.nozzle import pivot

TIP = np.array((0.012, -0.004, 0.151))  # in the flange frame
SPOT = np.array((0.55, 0.10, 0.02))


def poses_around(turns: Array, slip: float = 0.0) -> Array:
    """Flange poses with these rotations (N, 3) [rad] that have the tip in the spot.

    The tip misses it by ``slip`` [m], one standard deviation an axis.
    """
    rng = np.random.default_rng(1)
    poses = np.tile(np.eye(4), (len(turns), 1, 1))
    poses[:, :3, :3] = (Rotation.from_rotvec((np.pi, 0, 0))
                        * Rotation.from_rotvec(turns)).as_matrix()
    poses[:, :3, 3] = SPOT + slip * rng.standard_normal((len(turns), 3)) - poses[:, :3, :3] @ TIP
    return poses


TURNS = 0.4 * np.array(((0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (1, 1, 1)))


def test_pivoting_finds_the_tip() -> None:
    found = pivot(poses_around(TURNS))
    np.testing.assert_allclose(found.offset, TIP, atol=1e-12)
    np.testing.assert_allclose(found.spot, SPOT, atol=1e-12)
    assert found.rms < 1e-12


def test_pivoting_says_how_well_it_knows_the_tip() -> None:
    rng = np.random.default_rng(2)
    ratios = []
    for _ in range(200):
        poses = poses_around(TURNS)
        poses[:, :3, 3] += 1e-4 * rng.standard_normal((len(TURNS), 3))
        found = pivot(poses)
        ratios.append((found.offset - TIP) / found.offset_sigma)
        assert found.rms < 3e-4
    assert 0.9 < np.sqrt(np.median(np.square(ratios)) / 0.455) < 1.2  # of a normal: 0.455


def test_a_pose_beside_the_spot_shows_in_its_residual() -> None:
    poses = poses_around(TURNS)
    poses[3, 0, 3] += 2e-3
    residuals = pivot(poses, largest_sigma=1.0).residuals
    assert np.argmax(residuals) == 3
    assert residuals[3] > 5e-4


@pytest.mark.parametrize(('turns', 'words'), [
    (TURNS[:2], 'expected 3 poses or more, found 2'),
    (np.zeros((6, 3)), 'turned about none'),
    (TURNS[[0, 1, 2, 1]], 'turned about one only'),
    (0.02 * TURNS, 'found .* mm: turn the flange further'),
])
def test_pivoting_too_little_is_refused(turns: Array, words: str) -> None:
    with pytest.raises(CalibrationError, match=words):
        pivot(poses_around(turns, slip=1e-4))
