"""Planar stress scenes: their truth, compared with geometry by hand and with their images."""

from functools import cache
from unittest.mock import patch

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from bpc_perception.core.geometry import invert, transform
from bpc_sim.ink.curves import line, meander, ring, turtle
from bpc_sim.ink.deposit import constant_width, Deposit
from bpc_sim.stress import planar_print
from bpc_sim.stress.catalogue import PLANAR, STRESS
from bpc_sim.stress.truth import classify_samples, drop_clearance, find_clearances, Truth

MM = 1e-3  # [m]


def categories(deposit, s_mm, pixel=0.1 * MM, drops=None):
    return classify_samples(deposit, np.array(s_mm, float) * MM, pixel, drops).tolist()


@pytest.fixture
def cross():
    """A path that crosses its own start, 10 mm on, at a right angle; 2 mm wide."""
    loop = (1.5 * np.pi * 5 * MM, -1.5 * np.pi)
    return Deposit(turtle(((15 * MM, 0), loop, (15 * MM, 0))), constant_width(2 * MM))


def test_a_junction_is_where_the_cross_segment_meets_another_pass(cross):
    # The first leg is crossed at (10, 0); the other strand lies on it from 9 to 11 mm.
    np.testing.assert_allclose(
        cross.curve.points(np.array((10 * MM, cross.curve.length - 10 * MM))),
        ((10 * MM, 0),) * 2, atol=1e-15)
    J, M, E = Truth.JUNCTION, Truth.MEASURED, Truth.EDGE
    assert categories(cross, (8.7, 8.9, 9.01, 10, 10.99, 11.1, 11.3)) == [M, E, J, J, J, E, M]
    found = find_clearances(cross, np.array((8.7, 10.0)) * MM)
    assert np.isinf(found.same_pass).all()
    np.testing.assert_allclose(found.other_pass, (0.3 * MM, -1 * MM), atol=1e-9)


def test_a_gap_that_another_pass_crosses_is_a_junction():
    loop = (1.5 * np.pi * 5 * MM, -1.5 * np.pi)
    deposit = Deposit(turtle(((15 * MM, 0), loop, (15 * MM, 0))), constant_width(2 * MM),
                      np.array(((7 * MM, 13 * MM),)))
    J, G, E = Truth.JUNCTION, Truth.GAP, Truth.EDGE
    assert categories(deposit, (6.95, 7.05, 8, 8.9, 9.1, 10, 12)) == [E, E, G, E, J, J, G]


def test_strands_that_touch():
    s = (5, 40, 75)
    for pitch, expected in ((1.9, Truth.JUNCTION), (2.0, Truth.JUNCTION), (2.1, Truth.EDGE),
                            (2.25, Truth.MEASURED)):
        deposit = Deposit(meander(pitch * MM, 20 * MM, 4), constant_width(2 * MM))
        assert categories(deposit, s) == [expected] * 3


def test_corners_seams_ends_and_thin_ink_leave_it_open():
    corner = Deposit(turtle(((10 * MM, 0), (0, np.pi / 2), (10 * MM, 0))), constant_width(2 * MM))
    M, E = Truth.MEASURED, Truth.EDGE
    assert categories(corner, (0.05, 0.2, 8.7, 8.9, 10, 11.1, 11.3, 19.95)) \
        == [E, M, M, E, E, E, M, E]
    closed = Deposit(ring(10 * MM), constant_width(2 * MM))
    length = 20 * np.pi
    assert categories(closed, (0, 0.9, 1.1, length - 1.1, length - 0.9)) == [E, E, M, M, E]
    thin = Deposit(line(10 * MM), constant_width(0.29 * MM))
    assert categories(thin, (5,)) == [E]


def test_drops():
    deposit = Deposit(line(20 * MM), constant_width(2 * MM))
    drops = np.array(((0, 1.5 * MM, 1 * MM), (5 * MM, -2.5 * MM, 1 * MM)))
    s = np.array((10, 10 + np.sqrt(0.75), 12, 15)) * MM
    # The side at y = 1 mm leaves the drop where x^2 + 0.5^2 = 1.
    expected = (-0.5 * MM, 0, (np.hypot(2, 0.5) - 1) * MM, 0.5 * MM)
    np.testing.assert_allclose(drop_clearance(deposit, s, drops), expected, atol=1e-12)
    E, M = Truth.EDGE, Truth.MEASURED
    assert categories(deposit, (10, 10.9, 11.2, 15), drops=drops) == [E, E, M, M]


def test_mesh_has_sixteen_crossings_and_the_eight_one():
    for name, crossings in (('mesh', 16), ('figure_eight', 1)):
        junction = built(name)[0].expected == Truth.JUNCTION
        runs = np.diff(np.concatenate(([0], junction.astype(int)))) == 1
        assert runs.sum() == 2 * crossings  # on both passes
        assert junction.sum() == pytest.approx(2 * crossings * 2 / 0.2, rel=0.11)


@cache
def built(name):
    """Return a scene of seed 0, and the fraction of ink in each pixel of its image."""
    coverage = []
    expose = planar_print.expose

    def watched(light, covered, imaging, rng):
        coverage.append(covered)
        return expose(light, covered, imaging, rng)

    with patch.object(planar_print, 'expose', watched):
        return STRESS[name](0), *coverage


def project(scene):
    """Return the pixels (N, 2) of the path, and its unit normals (N, 2) in the image."""
    T_camera_base = invert(scene.T_base_camera)
    uv = scene.capture.camera.pixels(transform(T_camera_base, scene.points))
    along = np.gradient(uv, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return uv, np.stack((-along[:, 1], along[:, 0]), axis=1)


@pytest.mark.parametrize('name', PLANAR)
def test_truth_is_what_the_picture_shows(name):
    scene, coverage = built(name)
    uv, normal = project(scene)
    # A line across each sample, and the length of ink on it without a break.
    step, half = 0.1, 40
    steps = np.arange(0, half, step) + step / 2
    extent = np.zeros(len(scene))
    for side in (-1, 1):
        places = uv[:, None] + side * steps[:, None] * normal[:, None]
        ink = map_coordinates(coverage, (places[..., 1], places[..., 0]), order=1)
        # Bilinear reading smears an edge over a pixel either way.
        extent += (ink * np.logical_and.accumulate(ink > 0.005, axis=1)).sum(axis=1) * step
    extent *= scene.pixel
    expected = scene.expected
    measured = expected == Truth.MEASURED
    error = extent[measured] - scene.thickness[measured]
    assert np.abs(error).max() < 0.05 * MM  # next to an end
    assert np.abs(error).mean() < 0.006 * MM
    assert (extent[expected == Truth.GAP] < 0.05 * MM).all()
    junction = expected == Truth.JUNCTION
    assert (extent[junction] > scene.thickness[junction] + 0.4 * MM).all()
    assert (scene.thickness[measured] > 0).all()
    assert (scene.thickness[expected == Truth.GAP] == 0).all()


SHARES = {  # of JUNCTION and of EDGE, at most
    'mesh': (0.25, 0.06), 'figure_eight': (0.06, 0.04), 'touching_meander': (0.9, 0.1),
    'frame': (0, 0.1), 'ring': (0, 0.03), 'spills': (0, 0.1), 'gaps_and_ends': (0, 0.03),
}


@pytest.mark.parametrize('name', PLANAR)
def test_planar_scenes(name):
    scene = built(name)[0]
    assert scene.name == name
    steps = np.linalg.norm(np.diff(scene.points, axis=0), axis=1)
    np.testing.assert_allclose(np.diff(scene.arc_length), 0.2 * MM, rtol=5e-3)
    assert steps.max() < 0.201 * MM
    share = np.bincount(scene.expected, minlength=5) / len(scene)
    junction, edge = SHARES.get(name, (0, 0.01))
    assert share[Truth.JUNCTION] <= junction
    assert share[Truth.EDGE] <= edge
    assert share[Truth.HIDDEN] == 0
    uv, _ = project(scene)
    assert (np.abs(uv - 255.5) < 254).all()
    path = scene.path
    assert path.covers(scene.capture.stamp_ns)
    assert len(path.until(scene.capture.stamp_ns)) == len(scene)


def contrast(scene, weights=(0.299, 0.587, 0.114)):
    """Return the median light of MEASURED pixels of the path, less that 3 mm beside them."""
    uv, normal = project(scene)
    grey = scene.capture.image @ np.array(weights)
    measured = scene.expected == Truth.MEASURED
    ink, left, right = (map_coordinates(grey, (uv + d * normal)[measured].T[::-1], order=1)
                        for d in (0, 30, -30))
    return np.median(ink - (left + right) / 2)


def test_pictures_are_as_hard_as_they_say():
    assert abs(contrast(built('low_contrast_30')[0])) == pytest.approx(30, abs=2)
    assert abs(contrast(built('low_contrast_15')[0])) == pytest.approx(15, abs=2)
    assert abs(contrast(built('red_on_green')[0])) < 2
    assert abs(contrast(built('red_on_green')[0], (1, -1, 0))) > 150
    assert contrast(built('light_on_dark')[0]) > 60
    lamp = built('lamp_35')[0].capture.image.astype(float).max(axis=2)
    assert lamp[:40, :40].mean() / lamp[-40:, -40:].mean() == pytest.approx(1.32 / 0.68, rel=0.05)
    glare = built('glare_ridge')[0]
    uv, normal = project(glare)
    across = [np.median(map_coordinates(glare.capture.image[..., 0].astype(float),
                                        (uv + d * normal).T[::-1], order=1)) for d in (-4, 0, 4)]
    assert max(across[0], across[2]) - across[1] > 60


@pytest.mark.parametrize('tenths', [2, 4, 6])
def test_a_shifted_path_keeps_its_distance(tenths):
    scene, coverage = built(f'path_offset_{tenths:02}')
    uv, normal = project(scene)
    measured = scene.expected == Truth.MEASURED
    steps = np.arange(-20, 20, 0.1)
    places = uv[:, None] + steps[:, None] * normal[:, None]
    ink = map_coordinates(coverage, (places[..., 1], places[..., 0]), order=1)[measured]
    middle = (ink * steps).sum(axis=1) / ink.sum(axis=1) * scene.pixel
    np.testing.assert_allclose(np.abs(middle), tenths * 0.1 * MM, atol=0.02 * MM)


@pytest.mark.parametrize('name', ['mesh', 'spills', 'gaps_and_ends'])
def test_the_seed_decides(name):
    scene, _ = built(name)
    again, other = (STRESS[name](seed) for seed in (0, 1))
    np.testing.assert_array_equal(again.capture.image, scene.capture.image)
    np.testing.assert_array_equal(again.expected, scene.expected)
    assert (other.capture.image != scene.capture.image).mean() > 0.5
