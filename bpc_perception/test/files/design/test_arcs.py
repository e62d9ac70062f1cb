"""Arcs against the geometry of circles."""

from __future__ import annotations

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

from bpc_perception.files.design.arcs import Arc, CHORD_MM


@settings(max_examples=200)
@given(radius=st.floats(0.05, 5000), begin=st.floats(-3, 3), turn=st.floats(0.1, 6.1),
       clockwise=st.booleans(), rise=st.floats(-5, 5), by_radius=st.booleans())
def test_chords_lie_on_the_circle(radius: float, begin: float, turn: float, clockwise: bool,
                                  rise: float, by_radius: bool) -> None:
    way = -turn if clockwise else turn
    centre = np.array((3.0, -2.0))
    start, end = (np.array((*(centre + radius * np.array((np.cos(angle), np.sin(angle)))), z))
                  for angle, z in ((begin, 1.0), (begin + way, 1.0 + rise)))
    if by_radius and abs(turn - np.pi) > 0.1:
        arc = Arc(start, end, clockwise, None, None, radius if turn < np.pi else -radius, 1)
    else:
        arc = Arc(start, end, clockwise, *(centre - start[:2]), None, 1)
    points = np.vstack((start, arc.points()))
    away = points[:, :2] - centre
    assert np.hypot(*away.T) == pytest.approx(radius, rel=1e-6)
    np.testing.assert_array_equal(points[-1], end)
    # Each chord turns the same way, evenly in height, and all together as far as asked.
    angles = np.unwrap(np.arctan2(away[:, 1], away[:, 0]))
    assert angles[-1] - angles[0] == pytest.approx(way, abs=1e-6)
    np.testing.assert_allclose((angles - angles[0]) / way, (points[:, 2] - 1.0) / rise
                               if abs(rise) > 1e-3 else (angles - angles[0]) / way, atol=1e-6)
    middle = (away[1:] + away[:-1]) / 2
    sag = radius - np.hypot(*middle.T)
    assert sag.max() <= max(CHORD_MM, radius * (1 - np.cos(np.pi / 8))) + 1e-6
    assert sag.max() <= CHORD_MM + 1e-6 or radius < 0.1
    assert len(points) < 5000


@pytest.mark.parametrize('clockwise', [True, False])
def test_an_arc_that_ends_where_it_starts_is_a_whole_turn(clockwise: bool) -> None:
    start = np.array((1.0, 0.0, 0.0))
    points = Arc(start, np.add(start, (0, 0, 1)), clockwise, -1.0, 0.0, None, 1).points()
    assert points[0, 1] * (-1 if clockwise else 1) > 0
    steps = np.linalg.norm(np.diff(np.vstack((start, points))[:, :2], axis=0), axis=1)
    assert steps.sum() == pytest.approx(2 * np.pi, rel=3e-3)


def test_rounded_ends_are_met() -> None:
    start, end = np.array((10.0, 0.0, 0.0)), np.array((0.0, 10.01, 0.0))
    points = Arc(start, end, False, -10.0, 0.0, None, 1).points()
    np.testing.assert_array_equal(points[-1], end)
    radii = np.hypot(*points[:, :2].T)
    assert (np.diff(radii) > 0).all()
