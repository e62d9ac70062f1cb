"""Height and area of beads whose sections can be summed up by hand."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.measurement.cross_section.height import Shapes
from bpc_perception.core.measurement.cross_section.size import (
    Crosswise,
    SHAPE_SIGMA,
    sizes,
    U,
)
from bpc_perception.core.measurement.samples import Sizes
from bpc_perception.core.measurement.side_points import SidePoints

MM = 1e-3
WIDTH, RISE = 2 * MM, 0.6 * MM
SIDES = SidePoints(np.array(((0.0, 1.0, 0.0),)) * MM, np.array(((0.0, -1.0, 0.0),)) * MM,
                   np.array((WIDTH / 2,)), np.array((WIDTH / 2,)))
FLAT = np.zeros((1, len(U)))


def sized(before: Array, level: float = 0.0, roundness: float = 0.0,
          before_sigma: float = 0.0, may_hang: bool = True) -> Sizes:
    """A bead, of which level and rise are known to 0.01 mm each."""
    shapes = Shapes(np.array((level,)), np.array((RISE,)), np.array((roundness,)),
                    np.eye(2)[None] * (0.01 * MM)**2, np.array((False,)))
    return sizes(shapes, SIDES, np.array((0.02 * MM,)), before, np.array((before_sigma,)),
                 may_hang)


def test_a_parabola_on_the_bed_holds_two_thirds_of_its_box() -> None:
    found = sized(FLAT, level=-1e-9)
    assert found.height[0] == pytest.approx(RISE, rel=1e-5)
    assert found.area[0] == pytest.approx(2 / 3 * WIDTH * RISE, rel=1e-5)
    # Of level and rise: the area is width (d + 2/3 s); its width is known to 1 %.
    assert found.area_sigma[0] == pytest.approx(np.sqrt(
        (WIDTH * 0.01 * MM)**2 * (1 + 4 / 9) + (0.01**2 + SHAPE_SIGMA**2) * found.area[0]**2),
        rel=1e-4)
    assert found.height_sigma[0] == pytest.approx(np.sqrt(2) * 0.01 * MM, rel=1e-6)


def test_a_flat_bead_holds_more() -> None:
    """The integral of 1 - u^4 is 4/5 of its box."""
    assert sized(FLAT, roundness=1.0).area[0] == pytest.approx(4 / 5 * WIDTH * RISE, rel=1e-6)


def test_what_lay_there_before_is_no_ink_of_the_bead() -> None:
    """A wall: the same bead, 0.4 mm lower. From its foot on inside, all of it outside."""
    found = sized(RISE * (1 - U**2)[None] - 0.4 * MM, before_sigma=0.03 * MM)
    assert found.height[0] == pytest.approx(0.4 * MM)
    border = np.sqrt(1 / 3)  # where the bead below is as high as the foot
    inside = 0.4 * MM * border
    outside = RISE * ((1 - border) - (1 - border**3) / 3)
    assert found.area[0] == pytest.approx(WIDTH * (inside + outside), rel=5e-3)
    assert found.height_sigma[0] == pytest.approx(np.hypot(np.sqrt(2) * 0.01, 0.03) * MM)


def test_on_a_bed_feet_that_seem_to_be_higher_are_noise() -> None:
    """Cut off where they seem to be, half of the noise of the feet would always count as less."""
    higher, lower = (sized(FLAT, level, may_hang=False) for level in (0.02 * MM, -0.02 * MM))
    assert (higher.height[0] + lower.height[0]) / 2 == pytest.approx(RISE)
    assert higher.area[0] == pytest.approx(WIDTH * (2 / 3 * RISE + 0.02 * MM))
    assert sized(FLAT, 0.02 * MM).height[0] == pytest.approx(RISE)


def test_a_strand_that_hangs_counts_from_its_own_foot() -> None:
    found = sized(np.full_like(FLAT, -np.inf), level=0.2 * MM)
    assert found.height[0] == pytest.approx(RISE)
    assert found.area[0] == pytest.approx(2 / 3 * WIDTH * RISE, rel=1e-6)
    assert found.crest[0] == pytest.approx(RISE + 0.2 * MM)
    assert found.height_sigma[0] == pytest.approx(0.01 * MM)


def test_where_the_surface_before_is_not_known_nothing_is() -> None:
    found = sized(np.full_like(FLAT, np.nan), before_sigma=np.nan)
    assert np.isnan(found.height[0])
    assert np.isnan(found.area[0])


def test_low_points_that_the_picture_shows_beyond_an_edge_are_not_of_a_bead_on_ink() -> None:
    """The camera looks 20 degrees aslant at the flanks of a wall, a pixel of 0.2 mm apart.

    A ray that passes the left foot of the bead goes down below it, and 0.3 mm lower meets ink
    0.11 mm nearer to the middle. Edges are at 1 mm; a pixel at 0.95 mm shows both.
    """
    offset = np.array((-1.15, -0.95, -0.85, 0.0, 0.85, 0.95, 1.05)) * MM
    height = np.array((0.0, 0.0, 0.17, 0.6, 0.17, -0.2, -0.3)) * MM
    place = offset + height * np.tan(np.radians(20))
    cross = Crosswise(np.tile(place, (2, 1)), np.tile(height, (2, 1)), offset, 0.2 * MM,
                      np.zeros(2, np.intp), 0.2 * MM, 1, 1.0)
    two = SidePoints(*(np.repeat(each, 2, axis=0) for each in (
        SIDES.left, SIDES.right, SIDES.left_distance, SIDES.right_distance)))
    assert abs(place[-1]) < WIDTH / 2  # it seems to lie on the bead
    kept = cross.inside(two, np.array((True, False))).height
    assert np.isfinite(kept[0]).tolist() == [False, False, True, True, True, False, False]
    assert np.isfinite(kept[1]).all()
