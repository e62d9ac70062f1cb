"""Which path point is nearest to each sample of sections."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_perception.core.measurement.cross_section.sections.territory import find_nearest

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
