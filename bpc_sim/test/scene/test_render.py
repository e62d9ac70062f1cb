"""Rendered captures, compared with the geometry that they show."""

from dataclasses import replace

import numpy as np
import pytest

from bpc_perception.core.geometry import invert, transform
from bpc_sim.ink.curves import archimedean, fermat, line, ring
from bpc_sim.ink.deposit import constant_width, Deposit, linear_width
from bpc_sim.printer.scenarios import bed_pose, camera_view
from bpc_sim.scene.camera import look_at, rays, View, zivid_m70
from bpc_sim.scene.imaging import Imaging
from bpc_sim.scene.render import render
from bpc_sim.scene.scene import Scene, Sensor

PERFECT = Sensor(Imaging(), shading=0, gloss=0, depth_noise=0, dropout=0, rim_dropout=0)
GAPS = np.array(((0.03, 0.036), (0.07, 0.08)))
DEPOSITS = {
    'spiral': Deposit(archimedean(1e-3, np.pi, 5 * np.pi), constant_width(2e-3), GAPS),
    'growing': Deposit(archimedean(1e-3, np.pi, 5 * np.pi), constant_width(2e-3), laid=0.06),
    'fermat': Deposit(fermat(7e-3, 1.8 * np.pi), linear_width(1e-3, 3e-3, 0.15), GAPS),
    'ring': Deposit(ring(0.012), constant_width(2e-3)),
}


def capture(deposit, view=None, sensor=PERFECT, seed=0, **scene):
    return render(Scene(deposit, bed_pose(), **scene), view or camera_view(), sensor,
                  np.random.default_rng(seed))


def on_surface(shot, view=None):
    """Return the points (N, 3) of the capture in the surface frame."""
    T_base_camera = (view or camera_view()).T_base_camera
    return transform(invert(bed_pose()) @ T_base_camera,
                     shot.cloud.reshape(-1, 3).astype(np.float64))


def coverage(shot):
    ink, bed = np.array(Imaging().ink), np.array(Imaging().bed)
    return ((bed - shot.image) @ (bed - ink) / ((bed - ink) @ (bed - ink)))


@pytest.mark.parametrize('deposit', DEPOSITS.values(), ids=DEPOSITS.keys())
def test_cloud_lies_on_bed_and_bead(deposit):
    points = on_surface(capture(deposit))
    height = deposit.height(points[:, :2])
    # Except at the flat ends: there the cloud lies on the wall, between bed and top.
    location = deposit.locate(points[:, :2])
    wall = np.abs(location.s[:, None] - deposit.runs.ravel()).min(axis=1) < 1e-5
    np.testing.assert_allclose(points[~wall, 2], height[~wall], atol=3e-7)
    assert points[:, 2].max() == pytest.approx(deposit.height(deposit.curve.points(
        deposit.runs[-1] @ ((0.5,), (0.5,)))).max(), rel=0.3)
    assert (points[wall, 2] > -1e-7).all()


@pytest.mark.parametrize('tilt', [0.0, 25.0])
@pytest.mark.parametrize('deposit', DEPOSITS.values(), ids=DEPOSITS.keys())
def test_image_covers_the_projected_outline(deposit, tilt):
    # Without height, the camera sees exactly the perspective image of the ribbon.
    flat = replace(deposit, height_ratio=1e-9)
    view = camera_view(tilt=np.radians(tilt))
    T_camera_surface = invert(view.T_base_camera) @ bed_pose()
    area = 0.0
    for start, end in flat.runs:
        left, right = flat.sides(np.linspace(start + 1e-12, end - 1e-12, 4000))
        outline = np.concatenate((left, right[::-1]))
        u, v = view.camera.pixels(transform(
            T_camera_surface, np.column_stack((outline, np.zeros(len(outline)))))).T
        area += abs(np.sum(u * np.roll(v, -1) - v * np.roll(u, -1))) / 2
    assert coverage(capture(flat, view)).sum() == pytest.approx(area, rel=1e-3)


def test_edges_of_a_bead_are_those_of_its_footprint():
    # At 25 degrees the rim does not hide itself: the image of a bead is that of its footprint,
    # except at the two ends of the line.
    deposit = Deposit(line(0.08), constant_width(3e-3))
    flat = replace(deposit, height_ratio=1e-9)
    np.testing.assert_allclose(coverage(capture(deposit)), coverage(capture(flat)), atol=0.01)


def test_a_steep_bead_hides_the_bed_behind():
    # A strand along x, seen from the side of -y: its far edge moves away, its near edge stays.
    deposit = Deposit(line(0.08), constant_width(3e-3), height_ratio=1.0)
    columns = [coverage(capture(d))[:, 160]
               for d in (deposit, replace(deposit, height_ratio=0.3))]
    near = [np.flatnonzero(column > 0.5)[-1] for column in columns]
    assert near[0] == near[1]
    # The tangent to 4 x 3 mm: h = top - steep d^2 along the ray, at 25.3 degrees.
    eye_y, eye_z = 0.34 * np.sin(np.radians(25)), 0.34 * np.cos(np.radians(25))
    slope, steep, top = eye_z / (eye_y + 1.8e-3), 4 * 1.0 / 3e-3, 3e-3
    touch = slope / (2 * steep)
    shift = touch + (top - steep * touch**2) / slope - 1.5e-3
    pixel = 0.34 / 1781.45 / np.cos(np.radians(25))
    assert columns[0].sum() - columns[1].sum() == pytest.approx(shift / pixel, rel=0.03)


def test_height_above_the_middle():
    deposit = Deposit(line(0.04), constant_width(2e-3))
    points = on_surface(capture(deposit))
    assert points[:, 2].max() == pytest.approx(0.6e-3, abs=1e-5)
    assert points[np.abs(points[:, 1]) > 1.01e-3, 2].max() < 1e-7


def test_noise_and_missing_points():
    empty = Deposit(line(0.04), constant_width(2e-3), laid=0.0)
    sensor = replace(PERFECT, depth_noise=5e-5, dropout=0.02)
    shot = capture(empty, sensor=sensor)
    missing = np.isnan(shot.cloud)
    assert (missing.any(axis=2) == missing.all(axis=2)).all()
    assert missing.mean() == pytest.approx(0.02, rel=0.1)
    ideal = capture(empty).cloud
    error = (shot.cloud - ideal)[..., 2][~missing[..., 2]]
    assert np.std(error) == pytest.approx(5e-5 * (0.34 / 0.4)**2, rel=0.03)
    np.testing.assert_array_equal(shot.cloud, capture(empty, sensor=sensor).cloud)
    # Noise moves a point along its ray: it stays on its pixel.
    uv = shot.camera.pixels(shot.cloud[0].astype(np.float64))
    np.testing.assert_allclose(uv[:, 0][~missing[0, :, 0]],
                               np.flatnonzero(~missing[0, :, 0]), atol=1e-3)


def test_rim_loses_points_and_glare_too():
    deposit = DEPOSITS['ring']
    shot = capture(deposit, sensor=replace(PERFECT, rim_dropout=1.0))
    clean = on_surface(capture(deposit))
    missing = np.isnan(shot.cloud[..., 2]).ravel()
    offset = np.abs(np.hypot(*clean[:, :2].T) - 0.012)
    assert missing[np.abs(offset - 1e-3) < 1e-4].all()
    assert not missing[np.abs(offset - 1e-3) > 4e-4].any()
    glare = capture(deposit, sensor=replace(PERFECT, imaging=Imaging(glare_spots=10)))
    assert np.isnan(glare.cloud[glare.image.min(axis=2) == 255]).all()


def test_nozzle_stands_in_front():
    T_base_tip = bed_pose() @ np.diag((1.0, -1.0, -1.0, 1.0))
    T_base_tip[:3, 3] += 1e-3 * bed_pose()[:3, 2]
    shot = capture(DEPOSITS['spiral'], T_base_tip=T_base_tip)
    points = on_surface(shot)
    nozzle = points[points[:, 2] > 0.9e-3]
    radius = 0.635e-3 + np.tan(0.08) * (nozzle[:, 2] - 1e-3)
    np.testing.assert_allclose(np.hypot(*nozzle[:, :2].T), radius, atol=1e-7)
    assert len(nozzle) > 1000
    # It reaches up from the tip, away from the camera, out of the image.
    metal = np.abs(shot.image.astype(float) - (150, 152, 158)).max(axis=2) < 1
    assert metal[0].any()
    assert not metal[130:].any()


def test_windows_of_the_camera_see_the_same():
    full, small = zivid_m70(), zivid_m70(320, 240)
    assert (full.width, full.height) == (1944, 1200)
    shift = full.K[:2, 2] - small.K[:2, 2]
    np.testing.assert_array_equal(shift, np.rint(shift))
    assert np.abs(small.K[:2, 2] - (159.5, 119.5)).max() <= 0.5
    uv = np.array(((10.0, 20.0),))
    np.testing.assert_allclose(rays(small, uv), rays(full, uv + shift), atol=1e-12)
    half = zivid_m70(972, 600, scale=0.5)
    # The border between pixels 1 and 2 of the full image is the end of pixel 0 of the half image.
    np.testing.assert_allclose(rays(half, np.array((0.5, 0.5))), rays(full, np.array((1.5, 1.5))))
    with pytest.raises(ValueError, match='at most'):
        zivid_m70(320, 240, scale=0.1)


def test_look_at():
    pose = look_at(np.array((0.0, 0.0, 0.5)), np.zeros(3), np.array((1.0, 0.0, 0.0)))
    np.testing.assert_allclose(pose[:3, :3], np.diag((1, -1, -1)), atol=1e-15)
    np.testing.assert_allclose(pose[:3, 3], (0, 0, 0.5))


def test_distortion_is_refused():
    view = camera_view()
    bent = View(replace(view.camera, distortion=np.full(5, 0.1)), view.T_base_camera)
    with pytest.raises(ValueError, match='no distortion'):
        capture(DEPOSITS['ring'], bent)
