"""Curves, compared with closed forms, numerical integration and finite differences."""

import numpy as np
import pytest
from scipy.integrate import quad

from bpc_sim.ink import curves
from bpc_sim.ink.curve_pieces import curve_pieces

ALL = {
    'line': curves.line(0.05),
    'ring': curves.ring(0.015),
    'arc': curves.ring(0.015, 1.0),
    'meander': curves.meander(6e-3, 0.036, 5),
    'archimedean': curves.archimedean(1.2e-3, np.pi, 6 * np.pi),
    'archimedean from the origin': curves.archimedean(1.2e-3, 0.0, 4 * np.pi),
    'fermat': curves.fermat(9e-3, 2 * np.pi),
    'turtle': curves.turtle(((0.01, 0), (0.02, 4), (0.012, 0), (0.015, -2.5)), (0.001, 0.002), 1),
}


@pytest.fixture(params=ALL.values(), ids=ALL.keys())
def curve(request):
    return request.param


def test_arc_length_is_distance_travelled(curve):
    s = curve.uniform(20001)
    travelled = np.linalg.norm(np.diff(curve.points(s), axis=0), axis=1).sum()
    # A chord is shorter than its arc by (step curvature)^2 / 24: some 1e-7 here.
    assert travelled == pytest.approx(curve.length, rel=1e-6)


def test_tangents_are_derivatives(curve):
    h = 1e-6
    s = np.linspace(2 * h, curve.length - 2 * h, 500)
    slopes = (curve.points(s + h) - curve.points(s - h)) / (2 * h)
    np.testing.assert_allclose(curve.tangents(s), slopes, atol=5e-7)
    np.testing.assert_allclose(np.linalg.norm(curve.tangents(s), axis=1), 1, atol=1e-12)


def test_normals_point_left(curve):
    s = curve.uniform(50)
    t, n = curve.tangents(s), curve.normals(s)
    np.testing.assert_allclose(t[:, 0] * n[:, 1] - t[:, 1] * n[:, 0], 1, atol=1e-12)


def test_archimedean_length_and_ends():
    # a / 2 (phi sqrt(1 + phi^2) + asinh phi) by hand for the paper's spiral: 208.33 mm.
    curve = ALL['archimedean']
    expected, _ = quad(lambda phi: 1.2e-3 * np.sqrt(1 + phi**2), np.pi, 6 * np.pi, epsabs=1e-14)
    assert curve.length == pytest.approx(expected, abs=1e-12)
    ends = curve.points(np.array((0.0, curve.length)))
    np.testing.assert_allclose(ends, ((-1.2e-3 * np.pi, 0), (1.2e-3 * 6 * np.pi, 0)), atol=1e-12)


def test_fermat_is_symmetric_about_the_origin():
    curve = ALL['fermat']
    outer = 9e-3 * np.sqrt(2 * np.pi)
    expected, _ = quad(lambda r: np.sqrt(1 + 4 * (r / 9e-3)**4), 0, outer, epsabs=1e-14)
    assert curve.length == pytest.approx(2 * expected, abs=1e-12)
    s = curve.uniform(101)
    np.testing.assert_allclose(curve.points(s), -curve.points(curve.length - s), atol=1e-12)
    np.testing.assert_allclose(curve.points(s[50:51]), 0, atol=1e-12)


def test_ring_closes():
    ring = ALL['ring']
    assert ring.closed
    assert not ALL['arc'].closed
    np.testing.assert_allclose(*ring.points(np.array((0.0, ring.length))), atol=1e-15)


def test_meander_by_hand():
    # Two strands of 10 mm, 4 mm apart: at the middle of the turn, 5 + 2 mm to the right.
    curve = curves.meander(4e-3, 0.01, 2)
    assert curve.length == pytest.approx(0.02 + np.pi * 2e-3)
    s = np.array((0.0, 0.01, curve.length / 2, curve.length))
    np.testing.assert_allclose(
        1e3 * curve.points(s), ((-5, -2), (5, -2), (7, 0), (-5, 2)), atol=1e-12)


def test_feet_are_found_to_nanometres(curve):
    rng = np.random.default_rng(1)
    s = rng.uniform(0, curve.length, 400)
    # Smaller than the smallest radius of curvature, and than half the distance of two strands.
    offset = rng.uniform(-1e-3, 1e-3, 400)
    if curve is ALL['archimedean from the origin']:
        s, offset = np.clip(s, 0.01, None), offset / 2
    points = curve.points(s) + offset[:, None] * curve.normals(s)
    found = np.zeros(len(s), bool)
    for piece in curve_pieces(curve):
        near = piece.near(points, 2e-3)
        feet = piece.feet(points[near][:, None])
        found_s, found_offset, heading = feet.s[:, 0], feet.offset[:, 0], feet.heading[:, 0]
        right = ((found_s >= piece.start - 1e-9) & (found_s <= piece.end + 1e-9)
                 & (np.abs(found_s - s[near]) < 1e-3))
        np.testing.assert_allclose(found_s[right], s[near][right], atol=5e-8)
        np.testing.assert_allclose(found_offset[right], offset[near][right], atol=3e-9)
        tangents = np.stack((np.cos(heading), np.sin(heading)), axis=1)
        np.testing.assert_allclose(tangents[right], curve.tangents(s[near][right]), atol=5e-5)
        found[near] |= right
    assert found.all()


def test_turtle_by_hand():
    # 10 mm ahead, a corner to the left, 5 mm up, half a circle to the right.
    curve = curves.turtle(((0.01, 0), (0, np.pi / 2), (5e-3, 0), (np.pi * 2e-3, -np.pi)))
    assert curve.length == pytest.approx(0.015 + np.pi * 2e-3)
    assert curve.breaks == pytest.approx((0.01, 0.015))
    s = np.array((0.0, 0.01, 0.015, 0.015 + np.pi * 1e-3, curve.length))
    np.testing.assert_allclose(
        1e3 * curve.points(s), ((0, 0), (10, 0), (10, 5), (12, 7), (14, 5)), atol=1e-12)
    np.testing.assert_allclose(
        curve.tangents(s), ((1, 0), (0, 1), (0, 1), (1, 0), (0, -1)), atol=1e-12)
