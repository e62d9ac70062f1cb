"""What hand-eye calibration is made of, against plain geometry."""

from __future__ import annotations

import numpy as np
from perception_builders import pose
import pytest
from scipy.spatial.transform import Rotation

from bpc_perception.core.calibration.hand_eye import fit_rigid, second_turn
from bpc_perception.core.geometry import transform


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
