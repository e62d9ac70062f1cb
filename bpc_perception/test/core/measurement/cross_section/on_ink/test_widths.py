"""Widths of strokes on ink that light goes into: by its depth, or by the picture alone."""

from __future__ import annotations

import numpy as np
from perception_builders import sections_of
import pytest

from bpc_perception.core.measurement.cross_section.by_cloud.cloud_beads import (
    BeadModel,
    MOST_LEANS,
)
from bpc_perception.core.measurement.cross_section.edges.edges import Edges
from bpc_perception.core.measurement.cross_section.on_ink.below import Below, Beneath
from bpc_perception.core.measurement.cross_section.on_ink.method import depth_of_light, lifted
from bpc_perception.core.measurement.cross_section.on_ink.widths import find_widths

MM = 1e-3
COUNT, PIXEL, SPACING = 300, 0.17 * MM, 0.2 * MM
OFFSET = np.arange(-20, 21) * PIXEL / 2
SECTIONS = sections_of(np.zeros((COUNT, len(OFFSET))), OFFSET, PIXEL, SPACING)


def edges(distance: float) -> Edges:
    no = np.zeros(COUNT, bool)
    return Edges(np.full(COUNT, distance), np.full(COUNT, 0.02 * MM), no, no, no)


@pytest.mark.parametrize(('left', 'right', 'known'), [
    (1.0, 1.1, True), (1.0, 0.7, False), (0.7, 0.7, False)])
def test_where_the_cloud_lies_edges_count_that_are_not_those_of_ink_below(
        left: float, right: float, known: bool) -> None:
    """Ink below reaches out by 0.7 mm."""
    no = np.full(COUNT, np.nan)
    found = find_widths(
        SECTIONS, np.zeros(COUNT), (edges(left * MM), edges(right * MM)),
        beneath=Beneath(np.full(COUNT, 0.5 * MM), np.full(COUNT, 0.5 * MM)), cliffs=(no, no),
        reach=np.full((2, COUNT), 0.7 * MM), edge_sigma=0.01 * MM, beads=None, depth_sigma=0.0)
    assert (found.sure == known).all()
    if known:
        np.testing.assert_allclose(found.width, (left + right) * MM)


def test_points_below_the_surface_are_moved_to_it_along_the_rays() -> None:
    depth, lean = 0.2 * MM, 0.5
    surface = np.full((COUNT, len(OFFSET)), 0.6 * MM)
    true = sections_of(surface, OFFSET, PIXEL, SPACING)
    seen = lifted(true, -depth, np.full(COUNT, lean))
    np.testing.assert_allclose(seen.height, 0.4 * MM, rtol=1e-5)
    # Each lies on the ray of the point that it stands for.
    np.testing.assert_allclose(seen.place + lean * seen.height,
                               true.place + lean * true.height, atol=1e-8)
    again = lifted(seen, depth, np.full(COUNT, lean))
    np.testing.assert_allclose(again.place, true.place, atol=1e-8)


@pytest.mark.parametrize(('depth', 'told'), [(0.2, 0.2 * MM), (0.02, 0.0)])
def test_how_deep_light_goes_is_told_by_the_ink_on_the_bed(depth: float, told: float) -> None:
    sections = np.full((MOST_LEANS, 4), np.nan)
    sections[2] = 0.6, 2.0, 1.0, depth
    below = Below(clearance=0.5 * MM, width=2 * MM)
    model = BeadModel(sections, sigma=0.02)
    assert depth_of_light(model, below) == pytest.approx(told)
    assert depth_of_light(None, below) == 0.0
