"""The check of a calibration, from beads along a path that are seen shifted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from perception_builders import profile_of
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.check import offset
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.profile import ThicknessProfile

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
