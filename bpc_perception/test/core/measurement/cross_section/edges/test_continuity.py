"""Which of two edges goes on along the path."""

from __future__ import annotations

import numpy as np
from perception_builders import sections_of
import pytest

from bpc_perception.core.measurement.cross_section.edges.continuity import choose, Located

MM = 1e-3
COUNT, ODD = 41, 20  # sections, and the one of which it is not sure which edge is right
OFFSET = np.arange(-20, 21) * 0.05 * MM


@pytest.mark.parametrize(('near', 'far', 'right'), [
    (1.0, 1.6, 1.0),  # a drop spilled beside the bead
    (0.4, 1.0, 1.0),  # glare on the bead
    (1.0, np.nan, 1.0),  # glare on the bed: how that goes on is not seen
    (0.4, np.nan, np.nan),  # glare on both
])
def test_the_edge_that_goes_on_is_right(near: float, far: float, right: float) -> None:
    sections = sections_of(np.zeros((COUNT, len(OFFSET)), np.float32), OFFSET, 0.1 * MM, 0.2 * MM)
    sure = np.arange(COUNT) != ODD
    nearer, farther = (Located(np.where(sure, 1.0, value) * MM, np.zeros(COUNT))
                       for value in (near, far))
    chosen = choose(sections, nearer, farther, sure)
    assert chosen.distance[ODD] == pytest.approx(right * MM, nan_ok=True)
    assert chosen.sigma[ODD] > chosen.sigma[0]
