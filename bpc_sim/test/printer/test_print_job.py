"""Jobs and scenarios: robot, extruder and ink agree at every time."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bpc_perception.core.geometry import invert, transform
from bpc_sim.printer.print_job import SYRINGE_BORE_M
from bpc_sim.printer.scenarios import SCENARIOS, spiral_gaps


@pytest.fixture(scope='module')
def job():
    return spiral_gaps(speed=0.03)


@pytest.mark.parametrize('name', SCENARIOS)
def test_scenarios_fit_the_image(name):
    job = SCENARIOS[name](0.05)
    s = job.commanded.curve.uniform(500)
    on_bed = job.commanded.curve.points(s)
    # The line of the scenario purge, and the way from there, lie beside the bed.
    on_bed = on_bed[job.commanded.inked(s) & (on_bed[:, 1] > -0.05)]
    points = np.column_stack((on_bed, np.zeros(len(on_bed))))
    T_camera_surface = invert(job.view.T_base_camera) @ job.T_base_surface
    uv = job.view.camera.pixels(transform(T_camera_surface, points))
    assert ((uv > 8) & (uv < (311, 231))).all()
    travelled = sum(each.end - each.start for each in job.travels)
    travelling = sum((each.hop + abs(each.hop - each.rise)) / each.lift_speed + each.pause
                     + 2 * each.retraction / each.retraction_speed
                     + (each.end - each.start) / each.speed for each in job.travels)
    assert job.duration == pytest.approx((job.length - travelled) / 0.05 + travelling + 2)
    assert job.truth(s).max() < 2.5e-3


def test_spiral_is_the_sample_print():
    job = spiral_gaps()
    assert 0.15 < job.length < 0.22
    assert len(job.commanded.gaps) == 2
    assert len(job.faults) == 1
    width = job.truth(job.commanded.curve.uniform(1000))
    inked = width[width > 0]
    assert 1.7e-3 < inked.min() < inked.max() < 2.3e-3


def test_robot_moves_along_the_path(job):
    t = np.linspace(job.dwell_before, job.end_of_path, 200)
    tip = job.tip(t)
    speed = np.linalg.norm(np.diff(tip, axis=0), axis=1) / np.diff(t)
    np.testing.assert_allclose(speed, 0.03, rtol=5e-3)
    on_bed = transform(invert(job.T_base_surface), tip)
    np.testing.assert_allclose(on_bed[:, 2], job.tip_height, atol=1e-12)
    np.testing.assert_allclose(on_bed[:, :2], job.commanded.curve.points(job.laid(t)), atol=1e-12)


def test_flange_carries_the_nozzle(job):
    t = np.linspace(-1, job.duration + 1, 50)
    pose = job.flange_pose(t)
    np.testing.assert_allclose(
        pose[:, :3, :3] @ job.nozzle_offset + pose[:, :3, 3], job.tip(t), atol=1e-12)
    assert Rotation.from_matrix(pose[:, :3, :3]).as_matrix() == pytest.approx(pose[:, :3, :3])
    # The tool points into the bed.
    np.testing.assert_allclose(pose[0, :3, 2], -job.T_base_surface[:3, 2], atol=1e-12)
    assert job.flange_pose(1.0).shape == (4, 4)


def test_robot_lowers_and_lifts(job):
    t = np.array((0.0, job.dwell_before, job.end_of_path, job.duration))
    height = transform(invert(job.T_base_surface), job.tip(t))[:, 2]
    np.testing.assert_allclose(
        height - job.tip_height, (job.lift, 0, 0, job.lift), atol=1e-12)
    t = np.linspace(0, job.duration, 2000)
    step = np.abs(np.diff(job.tip(t), axis=0)).max()
    assert step < 0.3 * np.diff(t)[0] + 1e-9  # no jumps


def test_commanded_gaps_show_in_the_extruder_and_faults_do_not(job):
    def time(s):
        return job.dwell_before + np.asarray(s) / job.speed

    gaps = job.commanded.gaps.mean(axis=1)
    faults = job.faults.mean(axis=1)
    assert not job.extruding(time(gaps)).any()
    assert job.extruding(time(faults)).all()
    assert (job.truth(np.concatenate((gaps, faults))) == 0).all()
    np.testing.assert_array_equal(
        job.extruding(np.array((0, 0.999 * job.dwell_before, 1.001 * job.dwell_before,
                                job.end_of_path - 1e-3, job.end_of_path, job.duration))),
        (False, False, True, True, False, False))


def test_mass_is_conserved(job):
    flow = job.flow_rate(job.dwell_before + 0.1)
    assert flow == pytest.approx(np.pi / 4 * 2e-3**2 * 0.03)
    assert job.plunger_velocity(job.dwell_before + 0.1) == pytest.approx(
        flow / (np.pi / 4 * SYRINGE_BORE_M**2))
    # The pushed volume is that of a round filament along the path without the commanded gaps.
    runs = job.commanded.runs
    volume = np.pi / 4 * 2e-3**2 * (runs[:, 1] - runs[:, 0]).sum()
    moved = job.plunger_position(job.duration) * np.pi / 4 * SYRINGE_BORE_M**2
    assert moved == pytest.approx(volume, rel=1e-9)
    t = np.linspace(0, job.duration, 100001)
    np.testing.assert_allclose(
        np.concatenate(([0], np.cumsum(job.plunger_velocity(t[:-1]) * np.diff(t)))),
        job.plunger_position(t), atol=1e-7)


def test_captures_show_the_growing_print(job):
    blue = []
    for number, t in enumerate((0.0, 2.0, 4.0, job.duration)):
        shot = job.capture(t, number, stamp_ns=int(t * 1e9))
        assert shot.stamp_ns == int(t * 1e9)
        assert shot.image.shape == (228, 304, 3)
        blue.append(np.sum(shot.image[..., 2].astype(int) - shot.image[..., 0] > 60))
    assert blue[0] == 0
    assert blue == sorted(blue)
    # The nozzle is away from the finished print; its area is that of the ink within 5 percent.
    pixel = 0.34 / 1781.45
    area = job.deposit.area * np.cos(np.radians(25)) / pixel**2
    assert blue[-1] == pytest.approx(area, rel=0.05)


def test_captures_are_repeatable(job):
    first, again, other = (job.capture(3.0, number) for number in (5, 5, 6))
    np.testing.assert_array_equal(first.image, again.image)
    np.testing.assert_array_equal(first.cloud, again.cloud)
    assert (first.image != other.image).any()
