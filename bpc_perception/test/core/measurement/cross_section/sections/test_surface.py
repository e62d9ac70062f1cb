"""How high the surface below a nozzle lies, from the cloud beside its path."""

from __future__ import annotations

import numpy as np
from perception_builders import bed, capture_of, DOWN, surface
import pytest

from bpc_perception.core.measurement.cross_section.sections.lines import Lines
from bpc_perception.core.measurement.cross_section.sections.surface import nozzle_height
from bpc_perception.core.measurement.view import View

MM = 1e-3
UP = np.array((0.0, 0.0, 1.0))
TIP, OBSTACLE = 1.0 * MM, 2.5 * MM


def height_below(covered: float) -> float:
    """The surface's height above the tip, where the nozzle's body hides a share of the bed."""
    u = np.arange(20.0, 140.0)
    lines = Lines(surface(np.column_stack((u, np.full(len(u), 60.0)))) + TIP * UP,
                  np.tile((0.0, 1.0, 0.0), (len(u), 1)), np.arange(-20, 21) * 0.2 * MM)
    capture = capture_of(bed())
    capture.cloud[:, 20:20 + round(covered * 120), 2] -= 18 * MM
    bare = np.tile(np.abs(lines.offset) > 1.5 * MM, (len(u), 1))
    return nozzle_height(View(capture, DOWN, 0), lines, bare, UP, OBSTACLE)


@pytest.mark.parametrize('covered', [0.0, 0.4, 0.7, 0.9])
def test_what_is_above_the_tip_is_no_bed(covered: float) -> None:
    assert height_below(covered) == pytest.approx(-TIP, abs=0.02 * MM)


def test_where_nothing_else_is_seen_the_nozzle_offset_may_be_wrong() -> None:
    assert height_below(1.5) == pytest.approx(18 * MM - TIP, abs=0.02 * MM)
