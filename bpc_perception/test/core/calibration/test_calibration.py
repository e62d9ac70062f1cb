"""Nozzle offset and check of a calibration, from poses and beads placed by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from perception_builders import pose, profile_of, SECOND, START_NS
import pytest
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.check import offset
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.calibration.hand_eye import fit_rigid, second_turn
from bpc_perception.core.calibration.nozzle import pivot, rests
from bpc_perception.core.geometry import transform
from bpc_perception.core.profile import ThicknessProfile

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


def test_rests_are_found_between_movements() -> None:
    stamps = START_NS + np.arange(0, 8 * SECOND, SECOND // 100)
    time = (stamps - START_NS) / SECOND
    # Stands for 2 s, moves for 1 s, stands for 2 s, moves for 1 s, stands for 0.5 s, moves on.
    x = 0.1 * np.interp(time, (0, 2, 3, 5, 6, 6.5, 8), (0, 0, 1, 1, 2, 2, 3))
    x += 1e-5 * np.random.default_rng(3).standard_normal(len(x))
    poses = np.stack([pose((value, 0, 0.5)) for value in x])
    found = rests(stamps, poses)
    assert [rest.T_base_flange[0, 3] for rest in found] == pytest.approx([0.0, 0.1], abs=1e-4)
    assert (found[0].end_ns - START_NS) / SECOND == pytest.approx(2, abs=0.02)
    assert (found[1].start_ns - START_NS) / SECOND == pytest.approx(3, abs=0.02)
    assert len(rests(stamps, poses, 0.3)) == 3


def test_a_turn_on_the_spot_ends_a_rest() -> None:
    stamps = START_NS + np.arange(0, 4 * SECOND, SECOND // 100)
    angle = np.where(stamps < START_NS + 2 * SECOND, 0.0, 1.0)  # [degrees]
    found = rests(stamps, np.stack([pose(angles=(value, 0, 0)) for value in angle]))
    assert len(found) == 2


def test_points_are_laid_onto_others() -> None:
    T = pose((0.1, 0.2, 0.3), (30, 40, 50))
    points = np.random.default_rng(4).uniform(-1, 1, (9, 3)) * (1, 1, 0)  # of a plane
    np.testing.assert_allclose(fit_rigid(points, transform(T, points)), T, atol=1e-12)


@pytest.mark.parametrize(('axes', 'expected'), [
    (((1, 0, 0), (-1, 0, 0), (2, 0, 0), (-2, 0, 0)), 0.0),
    (((20, 0, 0), (-20, 0, 0), (0, 10, 0), (0, -10, 0)), 10 / np.sqrt(2)),
])
def test_turn_about_the_second_axis(axes: tuple[tuple[float, ...]], expected: float) -> None:
    turns = np.radians(np.array(axes, float))
    poses = [np.block([[Rotation.from_rotvec(turn).as_matrix(), np.zeros((3, 1))],
                       [np.zeros((1, 3)), 1]]) for turn in turns]
    assert np.degrees(second_turn(poses)) == pytest.approx(expected, abs=0.05)


# The check: beads along a path, seen shifted.

SHIFT = np.array((2e-4, -3e-4, 0.0))
SIDE = 5e-5


def profile_along(points: Array, shift: Array, side: float, noise: float = 0.0,
                  seed: int = 5) -> ThicknessProfile:
    """A bead of 1 mm along points (N, 3) of a level bed, seen ``shift`` off its place."""
    made = profile_of([1e-3] * len(points), spacing=float(np.linalg.norm(points[1] - points[0])))
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    across = np.column_stack((-along[:, 1], along[:, 0], np.zeros(len(along))))
    beside = side + across @ shift
    beside = beside + noise * np.random.default_rng(seed).standard_normal(len(beside))
    return replace(made, points=points, left_points=points + (beside + 5e-4)[:, None] * across,
                   right_points=points + (beside - 5e-4)[:, None] * across)


def circle(count: int = 400) -> Array:
    angle = np.linspace(0, 2 * np.pi, count)
    return 0.02 * np.stack((np.cos(angle), np.sin(angle), np.zeros(count)), axis=1)


def test_a_shift_is_told_from_a_bead_to_one_side() -> None:
    found = offset([profile_along(circle(), SHIFT, SIDE)])
    # The ends of the gradient have half its accuracy.
    np.testing.assert_allclose(found.shift, SHIFT, atol=1e-6)
    assert found.side == pytest.approx(SIDE, abs=1e-6)
    assert found.samples == 400


def test_the_uncertainty_of_the_shift_is_right() -> None:
    ratios = []
    for seed in range(100):
        found = offset([profile_along(circle(), SHIFT, SIDE, 5e-5, seed)])
        ratios.append((found.shift - SHIFT)[:2] / found.sigma)
    assert 0.7 < np.sqrt(np.mean(np.square(ratios))) < 1.3


@pytest.mark.parametrize(('shift', 'noise', 'holds'), [
    ((0, 0, 0), 1e-5, True), ((5e-4, 0, 0), 1e-5, False), ((2e-4, 0, 0), 1e-4, None)])
def test_whether_it_holds(shift: tuple[float, ...], noise: float, holds: bool | None) -> None:
    assert offset([profile_along(circle(), np.array(shift), 0, noise)]).holds(2e-4) is holds


def test_one_direction_tells_nothing() -> None:
    line = np.column_stack((np.linspace(0, 0.1, 400), np.zeros((400, 2))))
    with pytest.raises(CalibrationError, match='expected a print that goes in several directions'):
        offset([profile_along(line, SHIFT, SIDE, 1e-5)])


def test_little_is_not_enough() -> None:
    with pytest.raises(CalibrationError, match=r'expected 30 measured samples .*, found 20'):
        offset([profile_along(circle(20), SHIFT, SIDE)])
