"""Gaps in strokes on ink, in clouds that are known."""

from __future__ import annotations

import numpy as np
from perception_builders import sections_of
import pytest

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.measurement.cross_section.on_ink.bead import Beads
from bpc_perception.core.measurement.cross_section.on_ink.gaps import missing_ink

MM = 1e-3
COUNT, PIXEL, SPACING = 200, 0.17 * MM, 0.2 * MM
OFFSET = np.arange(-30, 31) * PIXEL / 2
WIDTH, TOP, LAYER = 2.0 * MM, 0.6 * MM, 0.5 * MM
LAID = np.full(COUNT, True)
SURFACE = np.full(COUNT, 0.2 * MM)  # of a bead below, which reaches above the foot of the upper


def found(bare: Flags, below: float, noise: float = 0.045 * MM, top: float = TOP,
          before: Array = SURFACE, missing: float = 0.0) -> Flags:
    """Gaps found in a stroke that is bare at some places, with a surface ``below`` there [m]."""
    rng = np.random.default_rng(2)
    bead = np.where(np.abs(OFFSET) < WIDTH / 2, top * (1 - (2 * OFFSET / WIDTH)**2), -LAYER)
    height = np.where(bare[:, None], below, bead) + rng.normal(0, noise, (COUNT, len(OFFSET)))
    height[rng.random(height.shape) < missing] = np.nan
    every = np.ones(COUNT)
    beads = Beads(top * every, 0 * every, WIDTH * every, 0 * every, 0 * every)
    return missing_ink(sections_of(height, OFFSET, PIXEL, SPACING), beads, ~bare, before)


def stretch(length: float) -> Flags:
    place = np.arange(COUNT) * SPACING
    return np.abs(place - place.mean()) < length / 2


@pytest.mark.parametrize('below', [0.2 * MM, -1 * MM], ids=['on a bead', 'over a pore'])
@pytest.mark.parametrize('missing', [0.0, 0.3])
def test_where_the_cloud_is_no_higher_than_before_there_is_a_gap(below: float,
                                                                 missing: float) -> None:
    bare = stretch(5 * MM)
    gap = found(bare, below, missing=missing)
    assert not gap[~bare].any()
    assert gap[stretch(3.4 * MM)].all()


@pytest.mark.parametrize('missing', [0.0, 0.3])
def test_ink_is_no_gap(missing: float) -> None:
    assert not found(stretch(0.0), 0.0, missing=missing).any()


def test_a_hole_shorter_than_one_and_a_half_widths_is_none() -> None:
    assert not found(stretch(2.6 * MM), 0.2 * MM).any()
    assert found(stretch(3.6 * MM), 0.2 * MM).any()


def test_half_a_bead_is_no_gap() -> None:
    """It was laid, though lower than it should be."""
    assert not found(stretch(5 * MM), 0.2 * MM + 0.5 * (TOP - 0.2 * MM)).any()


def test_where_the_cloud_has_no_points_there_is_no_gap() -> None:
    assert not found(stretch(5 * MM), np.nan).any()


def test_ink_as_low_as_noise_tells_no_gap() -> None:
    assert not found(stretch(5 * MM), 0.0, top=0.12 * MM, before=0 * SURFACE).any()


def test_without_a_bead_nothing_is_told() -> None:
    assert not found(LAID, 0.2 * MM).any()


def test_where_the_surface_before_is_not_known_a_pore_is_a_gap_all_the_same() -> None:
    bare = stretch(5 * MM)
    assert found(bare, -1 * MM, before=np.nan * SURFACE)[stretch(3 * MM)].all()
