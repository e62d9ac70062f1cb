"""Deposits: widths, gaps and areas that can be checked by hand."""

from dataclasses import replace

import numpy as np
import pytest

from bpc_sim.ink.curves import line, meander, ring
from bpc_sim.ink.deposit import constant_width, Deposit, knot_width, linear_width, random_gaps

MM = 1e-3  # [m]


@pytest.fixture
def strip():
    """50 mm x 2 mm along x, without ink from 10 to 20 mm and, overlapping, 15 to 25 mm."""
    return Deposit(line(50 * MM), constant_width(2 * MM),
                   np.array(((15, 25), (10, 20))) * MM)


def test_overlapping_gaps_merge(strip):
    np.testing.assert_allclose(strip.runs, np.array(((0, 10), (25, 50))) * MM)
    assert strip.area == pytest.approx(35 * 2 * MM**2)
    np.testing.assert_allclose(
        strip.width(np.array((0, 9.99, 10.01, 24.99, 25.01, 50)) * MM),
        np.array((2, 2, 0, 0, 2, 2)) * MM)


def test_growth_ends_at_the_nozzle(strip):
    areas = [replace(strip, laid=laid * MM).area for laid in (0, 5, 12, 30, 50, 60)]
    np.testing.assert_allclose(areas, np.array((0, 10, 20, 30, 70, 70)) * MM**2)
    growing = replace(strip, laid=30 * MM)
    np.testing.assert_array_equal(growing.inked(np.array((29.99, 30.01)) * MM), (True, False))
    nothing = replace(strip, laid=0.0)
    assert not nothing.inked(np.array((0.0, 10 * MM))).any()
    assert not nothing.covers(np.zeros((1, 2))).any()


def test_ends_are_flat_and_edges_exact(strip):
    micron = 1e-6
    inside = np.array(((-25 * MM + micron, 1 * MM - micron), (-15 * MM - micron, 0),
                       (0.1 * MM, -1 * MM + micron)))
    outside = np.array(((-25 * MM - micron, 0), (-15 * MM + micron, 0),
                        (-24 * MM, 1 * MM + micron),
                        (0.2 * MM - 1 * MM, 0), (0, 40 * MM)))
    assert strip.covers(inside).all()
    assert not strip.covers(outside).any()


def test_location_has_its_sign(strip):
    location = strip.locate(np.array(((-20, 0.25), (-20, -0.25))) * MM)
    np.testing.assert_allclose(location.s, 5 * MM, atol=1e-12)
    np.testing.assert_allclose(location.offset, np.array((0.25, -0.25)) * MM, atol=1e-12)
    np.testing.assert_allclose(location.heading, 0, atol=1e-12)
    np.testing.assert_allclose(location.margin, -0.75 * MM, atol=1e-12)


def test_far_away_is_unknown(strip):
    location = strip.locate(np.array(((0.0, 0.1),)))
    assert np.isnan(location.s).all()
    assert np.isinf(location.margin).all()


def test_groups_are_the_same_as_points(strip):
    rng = np.random.default_rng(0)
    groups = rng.uniform(-25 * MM, 25 * MM, (200, 1, 2)) * (1, 0.06) \
        + rng.uniform(-1e-4, 1e-4, (200, 9, 2))
    single = strip.locate(groups.reshape(-1, 2))
    grouped = strip.locate(groups)
    np.testing.assert_allclose(grouped.margin.ravel(), single.margin, atol=1e-12)


def test_bead_is_a_parabola(strip):
    y = np.array((0, 0.5, -0.5, 1, 1.1)) * MM
    height = strip.height(np.stack((np.full(5, -20 * MM), y), axis=1))
    np.testing.assert_allclose(height, 0.6 * MM * np.array((1, 0.75, 0.75, 0, 0)), atol=1e-12)


def test_ring_has_no_seam():
    deposit = Deposit(ring(10 * MM), constant_width(2 * MM))
    assert deposit.area == pytest.approx(np.pi * (11**2 - 9**2) * MM**2)
    x = np.linspace(9.001, 10.999, 50) * MM
    for y in (-1e-8, -1e-12, 0.0, 1e-12, 1e-8):
        assert deposit.covers(np.stack((x, np.full(50, y)), axis=1)).all()
    rng = np.random.default_rng(0)
    points = rng.uniform(-12 * MM, 12 * MM, (20000, 2))
    r = np.hypot(*points.T)
    np.testing.assert_array_equal(deposit.covers(points), (r >= 9 * MM) & (r <= 11 * MM))


def test_a_gap_before_the_seam_stays_a_gap():
    length = 2 * np.pi * 10 * MM
    deposit = Deposit(ring(10 * MM), constant_width(2 * MM),
                      np.array(((length - 5 * MM, length - 1 * MM),)))
    angle = np.array((-5.1, -4.9, -3, -1.1, -0.9, 0, 1)) / 10
    points = 10 * MM * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    np.testing.assert_array_equal(deposit.covers(points), (1, 0, 0, 0, 1, 1, 1))


def test_touching_strands_are_their_union():
    # Strands 2 mm apart and 2.5 mm wide: between the outer edges no bed is left.
    deposit = Deposit(meander(2 * MM, 20 * MM, 3), constant_width(2.5 * MM))
    y = np.linspace(-3.24, 3.24, 500) * MM
    assert deposit.covers(np.stack((np.zeros(500), y), axis=1)).all()
    assert not deposit.covers(np.array(((0, 3.26), (0, -3.26))) * MM).any()
    # A strand in a gap does not hide its neighbour.
    gap = replace(deposit, gaps=np.array(((5, 15),)) * MM)
    assert gap.covers(np.array(((0, -1.2),)) * MM).all()
    assert not gap.covers(np.array(((0, -1.3),)) * MM).any()


def test_widths():
    s = np.array((0, 25, 50)) * MM
    np.testing.assert_allclose(linear_width(1 * MM, 4 * MM, 50 * MM)(s),
                               np.array((1, 2.5, 4)) * MM)
    knots = knot_width(s, np.array((1, 2, 1)) * MM)
    np.testing.assert_allclose(knots(s), np.array((1, 2, 1)) * MM)
    assert knots(np.linspace(0, 50 * MM, 99)).max() <= 2 * MM
    cone = Deposit(line(50 * MM), linear_width(1 * MM, 4 * MM, 50 * MM))
    assert cone.area == pytest.approx(50 * 2.5 * MM**2)
    left, right = cone.sides(s)
    np.testing.assert_allclose(left - right, np.array(((0, 1), (0, 2.5), (0, 4))) * MM)


def test_random_gaps_are_as_in_the_paper():
    gaps = random_gaps(0.2, 10, 0.02, np.random.default_rng(3))
    assert gaps.shape == (10, 2)
    assert ((gaps >= 0) & (gaps <= 0.2)).all()
    np.testing.assert_allclose(np.diff(gaps[gaps[:, 1] < 0.2]), 0.004)
    np.testing.assert_array_equal(gaps, random_gaps(0.2, 10, 0.02, np.random.default_rng(3)))
