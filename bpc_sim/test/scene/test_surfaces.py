"""Beds: coordinates there and back, and what a camera sees of ink on a curved bed."""

from dataclasses import replace

import numpy as np
import pytest

from bpc_perception.core.geometry import invert, transform
from bpc_sim.ink.curves import archimedean
from bpc_sim.ink.deposit import constant_width, Deposit
from bpc_sim.printer.scenarios import bed_pose, camera_view
from bpc_sim.scene.imaging import Imaging
from bpc_sim.scene.render import render
from bpc_sim.scene.scene import Scene, Sensor
from bpc_sim.scene.surfaces import Cylinder, Plane

PERFECT = Sensor(Imaging(), shading=0, gloss=0, depth_noise=0, dropout=0, rim_dropout=0)
EYE = np.array((0.05, -0.1, 0.3))
SURFACES = {'plane': Plane(), 'cylinder': Cylinder(0.06)}


@pytest.fixture(params=SURFACES.values(), ids=SURFACES.keys())
def surface(request):
    return request.param


@pytest.fixture
def places():
    return np.random.default_rng(0).uniform(-0.02, 0.02, (50, 2))


def test_a_ray_comes_down_where_it_was_sent(surface, places):
    height = np.linspace(0, 2e-3, 50)
    directions = 0.5 * (surface.points(places, height) - EYE)
    found = surface.intersect(EYE, directions[:, None], height[:, None])
    np.testing.assert_allclose(found.places[:, 0], places, atol=1e-12)
    np.testing.assert_allclose(found.depth, 2, atol=1e-12)


def test_lean_is_the_motion_per_height(surface, places):
    directions = (surface.points(places, np.zeros(50)) - EYE)[:, None]
    level, step = np.full((50, 1), 5e-4), 1e-6
    above, below = (surface.intersect(EYE, directions, level + d).places for d in (step, -step))
    lean = surface.intersect(EYE, directions, level).lean
    np.testing.assert_allclose(lean, (above - below) / (2 * step), rtol=1e-6, atol=1e-9)


def test_axes_are_derivatives(surface, places):
    step, level = 1e-6, np.zeros(50)
    axes = surface.axes(places)
    np.testing.assert_allclose(axes @ axes.transpose(0, 2, 1), np.tile(np.eye(3), (50, 1, 1)),
                               atol=1e-12)
    for axis, shift in enumerate(np.eye(2) * step):
        moved = surface.points(places + shift, level) - surface.points(places - shift, level)
        np.testing.assert_allclose(axes[:, axis], moved / (2 * step), atol=1e-8)
    np.testing.assert_allclose(
        axes[:, 2], (surface.points(places, level + 1e-3) - surface.points(places, level)) * 1e3,
        atol=1e-12)


def test_cylinder_by_hand():
    # A quarter of the way around a cylinder of radius 60 mm, and 1 mm above it.
    place = np.array(((7e-3, 0.03 * np.pi),))
    np.testing.assert_allclose(Cylinder(0.06).points(place, np.array((1e-3,))),
                               ((7e-3, 0.061, -0.06),), atol=1e-12)


def test_rays_beside_the_cylinder_miss():
    directions = np.array(((0.0, 1.0, -1.0),))[:, None]
    found = Cylinder(0.06).intersect(EYE * (1, 0, 1), directions, np.zeros((1, 1)))
    assert np.isnan(found.depth).all()


@pytest.fixture
def scene():
    deposit = Deposit(archimedean(1e-3, np.pi, 5 * np.pi), constant_width(2e-3),
                      np.array(((0.03, 0.036),)))
    return Scene(deposit, bed_pose(), surface=Cylinder(0.06))


def test_cloud_lies_on_the_cylinder_and_its_bead(scene):
    view = camera_view()
    shot = render(scene, view, PERFECT, np.random.default_rng(0))
    x, y, z = transform(invert(bed_pose()) @ view.T_base_camera,
                        shot.cloud.reshape(-1, 3).astype(np.float64)).T
    found = np.isfinite(z)
    assert found.mean() > 0.95
    height = np.hypot(y, z + 0.06) - 0.06
    places = np.stack((x, 0.06 * np.arctan2(y, z + 0.06)), axis=1)
    expected = scene.deposit.height(places)
    location = scene.deposit.locate(places)
    wall = np.abs(location.s[:, None] - scene.deposit.runs.ravel()).min(axis=1) < 1e-5
    np.testing.assert_allclose(height[found & ~wall], expected[found & ~wall], atol=1e-6)
    assert height[found].max() == pytest.approx(0.6e-3, abs=1e-5)


def test_a_wide_cylinder_is_a_plane(scene):
    view = camera_view()
    flat, round_ = (render(replace(scene, surface=surface), view, PERFECT,
                           np.random.default_rng(0)) for surface in (Plane(), Cylinder(1e4)))
    np.testing.assert_allclose(round_.cloud, flat.cloud, atol=1e-6)
    assert np.abs(round_.image.astype(int) - flat.image).max() <= 3
