"""The truth of heights and areas, where it can be worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_sim.ink.bead_sizes import sizes_above
from bpc_sim.ink.curves import line
from bpc_sim.ink.deposit import constant_width, Deposit

MM = 1e-3
WIDTH, RISE = 2 * MM, 0.6 * MM
BEAD = Deposit(line(20 * MM), constant_width(WIDTH))
S = np.array((5.0, 10.0)) * MM


def test_a_parabola_on_the_bed() -> None:
    height, area = sizes_above(BEAD, [], S)
    np.testing.assert_allclose(height, RISE)
    np.testing.assert_allclose(area, 2 / 3 * WIDTH * RISE)


def test_a_bead_on_a_bead() -> None:
    """It counts from the bead below inside, and from its own foot outside of where both meet."""
    upper = Deposit(line(20 * MM), constant_width(WIDTH), base=constant_width(0.4 * MM))
    height, area = sizes_above(upper, [BEAD], S)
    border = np.sqrt(1 / 3)
    np.testing.assert_allclose(height, 0.4 * MM, rtol=1e-6)
    np.testing.assert_allclose(area, WIDTH * (0.4 * MM * border + RISE * (
        (1 - border) - (1 - border**3) / 3)), rtol=1e-3)


def test_a_bead_over_a_pore_counts_from_its_own_foot() -> None:
    hanging = Deposit(line(20 * MM), constant_width(WIDTH), base=constant_width(1 * MM))
    height, area = sizes_above(hanging, [], S)
    np.testing.assert_allclose(height, RISE)
    np.testing.assert_allclose(area, 2 / 3 * WIDTH * RISE)


def test_a_gap_has_no_area() -> None:
    gap = Deposit(line(20 * MM), constant_width(WIDTH), np.array(((4.0, 6.0),)) * MM)
    _, area = sizes_above(gap, [], S)
    assert area[0] == pytest.approx(0.0)
