"""What hand-eye calibration is made of, against plain geometry."""

from __future__ import annotations

import numpy as np
from perception_builders import camera, pose
import pytest
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.errors import CalibrationError
from bpc_perception.core.calibration.hand_eye import calibrate, fit_rigid, second_turn
from bpc_perception.core.calibration.sighting import Sighting
from bpc_perception.core.geometry import invert, transform


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


def seen(count: int, on_base: bool, noise: float = 2e-4) -> tuple[list[Array], list[Sighting]]:
    """Poses of the flange, and what a camera saw of a board at each, with noise [m]."""
    rng = np.random.default_rng(7)
    corners = np.array([(x, y, 0) for x in range(4) for y in range(3)]) * 0.02
    fixed, carried = pose((0.5, 0.1, 0.8), (170, 5, 30)), pose((0.02, 0.03, 0.06), (3, -4, 20))
    poses, sightings = [], []
    for _ in range(count):
        T_camera_board = pose(rng.uniform((-0.05, -0.03, 0.4), (0.05, 0.03, 0.6)),
                              rng.uniform(-25, 25, 3))
        # The one of camera and board that stands has the fixed pose, the other is carried.
        to_carried = T_camera_board if on_base else invert(T_camera_board)
        poses.append(fixed @ to_carried @ invert(carried))
        in_camera = transform(T_camera_board, corners) + rng.normal(0, noise, corners.shape)
        sightings.append(Sighting(corners, np.zeros((12, 2)), in_camera, 1.0, camera()))
    return poses, sightings


@pytest.mark.parametrize('count', [4, 12])
@pytest.mark.parametrize('noise', [1e-5, 1e-3])
@pytest.mark.parametrize('on_base', [True, False], ids=['eye_on_base', 'eye_in_hand'])
def test_the_wrong_mount_is_refused_and_the_right_one_named(
        on_base: bool, noise: float, count: int) -> None:
    found = calibrate(*seen(count, on_base, noise), on_base, use_cloud=True)
    assert found.best.rms[0] < 10 * noise
    right, wrong = ('eye_on_base', 'eye_in_hand')[::1 if on_base else -1]
    with pytest.raises(CalibrationError, match=(
            rf'^hand-eye: expected captures that fit {wrong}, found that they fit {right}, with a '
            rf'residual of [\d.]+ mm instead of ([\d.]+ mm|no solution); give --mount {right}$')):
        calibrate(*seen(count, on_base, noise), not on_base, use_cloud=True)


def test_where_no_mount_fits_none_is_recommended() -> None:
    poses, sightings = seen(8, True)
    apart = [pose(place) for place in np.random.default_rng(1).uniform(-0.1, 0.1, (8, 3))]
    spoilt = [each @ other for each, other in zip(poses, apart, strict=True)]
    residuals = [calibrate(spoilt, sightings, mount, True).best.rms[0] for mount in (True, False)]
    assert min(residuals) > 0.02
