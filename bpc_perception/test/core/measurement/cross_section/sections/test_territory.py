"""Which path point is nearest to each sample of sections."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_perception.core.measurement.cross_section.sections.territory import (
    find_nearest,
    leads_nearer,
)

MM = 1e-3
OFFSET = np.linspace(-3, 3, 25) * MM


@pytest.mark.parametrize('beyond', [0.0, 6.0, 20.0])
def test_sections_may_lie_beyond_the_path(beyond: float) -> None:
    """As those of a layer do that reaches farther out than what it lies on."""
    points = np.column_stack((np.linspace(0, 10, 51), np.zeros(51))) * MM
    start = np.array(((5.0, 2.0), (10 + beyond, 0.0), (-beyond, -beyond))) * MM
    lateral = np.array(((0.0, 1.0), (0.6, 0.8), (-1.0, 0.0)))
    nearest, distance = find_nearest(points, start, lateral, OFFSET)
    place = start[:, None] + OFFSET[:, None] * lateral[:, None]
    away = np.linalg.norm(place[:, :, None] - points, axis=-1)
    np.testing.assert_allclose(distance, away.min(axis=-1), atol=0.15 * MM)
    np.testing.assert_allclose(np.take_along_axis(away, nearest[..., None], 2)[..., 0], distance,
                               atol=1e-6)


@pytest.mark.parametrize(('angle', 'left', 'right'), [
    (90, False, False),  # the section runs beside the other pass
    (40, True, False), (140, False, True)])
def test_a_section_beside_a_crossing_comes_nearer_where_that_is_acute(
        angle: float, left: bool, right: bool) -> None:
    """A section along y, 1 mm ahead of where another pass crosses at an angle."""
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    found = leads_nearer(np.abs(1 * MM * sin - OFFSET * cos)[None].astype(np.float32), OFFSET)[0]
    near = np.abs(OFFSET) < 1.5 * MM
    assert found[near & (OFFSET > 0.1 * MM)].any() == left
    assert found[near & (OFFSET < -0.1 * MM)].any() == right


def test_a_section_comes_nearer_to_a_strand_beside_until_it_meets_it() -> None:
    found = leads_nearer(np.abs(OFFSET - 2 * MM)[None].astype(np.float32), OFFSET)[0]
    between = (OFFSET > 0.1 * MM) & (OFFSET < 1.9 * MM)
    assert found[between].all()
    assert not found[(OFFSET < -0.1 * MM) | (OFFSET > 2.1 * MM)].any()
