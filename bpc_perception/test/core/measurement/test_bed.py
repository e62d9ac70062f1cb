"""The plane of the bed, and what stands in front of it."""

from __future__ import annotations

import numpy as np
from perception_builders import bed, capture_of, DOWN, surface
import pytest

from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.measurement.bed import find_bed
from bpc_perception.core.measurement.view import View

MM = 1e-3
UP = np.array((0.0, 0.0, 1.0))
PATH = surface(np.column_stack((np.linspace(60, 100, 81), np.full(81, 60.0)))) + 1 * MM * UP


def with_nozzle(radius: float) -> Capture:
    """A capture in which a cone with a body on top stands on the middle of the path [pixels]."""
    capture = capture_of(bed())
    v, u = np.mgrid[0:120, 0:160]
    away = np.hypot(u - 80, v - 60)
    high = 1 * MM + np.where(away < 8, away * 2 * MM, 18 * MM)
    capture.cloud[..., 2] -= np.where(away < radius, high, 0.0)
    return capture


@pytest.mark.parametrize('radius', [0.0, 20.0, 30.0, 36.0])
def test_a_nozzle_in_front_of_most_of_a_small_print_is_no_bed(radius: float) -> None:
    found = find_bed(View(with_nozzle(radius), DOWN, 0), PATH)
    assert found.normal @ UP > np.cos(np.radians(1))
    np.testing.assert_allclose(found.height(PATH), 1 * MM, atol=0.1 * MM)


def test_where_hardly_anything_is_behind_the_path_the_path_may_be_wrong() -> None:
    found = find_bed(View(capture_of(bed()), DOWN, 0), PATH - 30 * MM * UP)
    np.testing.assert_allclose(found.height(PATH), 1 * MM, atol=0.1 * MM)
